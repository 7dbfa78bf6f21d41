// What is known of codecs without encoding: the memory that their work takes, to plan runs by, and
// the errors that their parameters promise. One entry a codec in estimates.cpp.
#pragma once

#include <optional>

#include "codecs/container.hpp"

namespace cvr::codecs {

/// Bytes that the work on a volume of the usual kind takes: a forecast to some tens of percent, no
/// bound. The volume itself, decoded voxels and the program are counted by whoever holds them.
struct MemoryEstimate {
  double file = 0;    ///< the encoded file
  double encode = 0;  ///< beside file and volume, while a volume in memory is encoded
  double decode = 0;  ///< beside file and decoded voxels, while a whole volume is decoded at once
  double open = 0;    ///< beside the file, by an opened decoder and what it needs for single voxels
  double access_ns = 200;  ///< of a single voxel
  double levels = 1;       ///< of detail
};

/// `info` is what the codec accepts; parameters are its own.
MemoryEstimate estimate_memory(const Codec& codec, const VolumeInfo& info,
                               const Parameters& parameters, unsigned threads);

/// Whether estimate_memory() knows the codec; it guesses for others.
bool has_estimate(const Codec& codec);

/// The largest absolute error that the parameters of a codec promise, in voxel values; none where
/// they promise none. Whether it was kept tells Decoder::recorded_error(): number formats may end
/// before the promise does.
std::optional<double> promised_error(const Codec& codec, const Parameters& parameters);

/// A promise of the parameters of a lossy codec, and what became of it.
struct Bound {
  double promised;  ///< the largest absolute error allowed
  double found;     ///< what the encoder measured on its own output
  bool kept() const { return found <= promised; }
};
/// None where the parameters promise nothing.
std::optional<Bound> bound_of(const OpenedFile& file, const Decoder& decoder);

}  // namespace cvr::codecs
