// What is known of codecs without encoding: the memory that their work takes and the time of a
// voxel, to plan runs by. One entry a codec in estimates.cpp.
#pragma once

#include "codecs/container.hpp"

namespace cvr::codecs {

/// Bytes that the work on a volume of the usual kind takes: a forecast to some tens of percent, no
/// bound. The volume itself, decoded voxels and the program are counted by whoever holds them.
struct MemoryEstimate {
  double file = 0;    ///< the encoded file
  double encode = 0;  ///< beside file and volume, while a volume in memory is encoded
  double decode = 0;  ///< beside file and decoded voxels, while a whole volume is decoded at once
  double open = 0;    ///< beside the file, by an opened decoder and what it needs for single voxels
  double access_ns = 200;  ///< of a single voxel; decides how many points random access times
  double levels = 1;       ///< of detail
};

/// `info` is what the codec accepts; parameters are its own. Of a codec without an entry it
/// guesses.
MemoryEstimate estimate_memory(const Codec& codec, const VolumeInfo& info,
                               const Parameters& parameters, unsigned threads);

}  // namespace cvr::codecs
