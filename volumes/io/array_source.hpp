// Volumes that lie in a file as one array of up to four axes (raw, NRRD, NIfTI): mapped where
// stored plainly, decoded into memory at the first read where stored as gzip, hexadecimal digits or
// text.
//
// Zero copy: data() is the mapping itself when the voxels are plain, with x fastest, little endian,
// aligned to their size and need no check. The stored voxels must be the last thing in the file, to
// the byte; what is coded is checked when it is decoded.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "volumes/io/file.hpp"
#include "volumes/io/format.hpp"
#include "volumes/source.hpp"

namespace cvr::volumes {

enum class ArrayEncoding { kPlain, kGzip, kHex, kText };

struct ArrayLayout {
  ArrayEncoding encoding = ArrayEncoding::kPlain;
  std::uint64_t start = 0;   ///< where the coded bytes begin in the file, unless kPlain
  std::uint64_t offset = 0;  ///< of the first stored voxel: in the file, or in the inflated stream
  bool at_end =
      false;  ///< the stored voxels are the last bytes of file or stream; `offset` is not read
  bool big_endian = false;
  bool reject_negative = false;       ///< see Interpretation
  bool whole_numbers = false;         ///< see Interpretation
  StoredType stored{VoxelType::kU8};  ///< read for kText only
  std::uint64_t stored_bytes = 0;  ///< of all stored voxels, of which the volume may be some steps
  std::array<std::uint64_t, 4> strides{};  ///< of x, y, z, t in stored voxels
  std::uint64_t first_step = 0;            ///< of the volume among the stored ones
};

/// Throws InputError, with both numbers, if the file has more or fewer bytes than its header says.
/// `info.extent` has passed check_extent. `other_files`: what has been read besides, for
/// VolumeSource::files().
std::unique_ptr<VolumeSource> open_array(MappedFile file, const VolumeInfo& info,
                                         const ArrayLayout& layout, Provenance provenance,
                                         std::vector<std::string> other_files = {});

}  // namespace cvr::volumes
