// Volumes that lie in a file as one array with x fastest (raw, NRRD, NIfTI): mapped where stored plainly,
// inflated into memory at the first read where stored as gzip.
//
// Zero copy: data() is the mapping itself when the voxels are plain, little endian, aligned to their size and
// need no check.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "volumes/io/file.hpp"
#include "volumes/source.hpp"

namespace cvr::volumes {

struct ArrayLayout {
  std::uint64_t offset = 0;  ///< of the first voxel: in the file, or in the inflated stream
  bool big_endian = false;
  bool reject_negative = false;  ///< see Interpretation
  std::optional<std::uint64_t>
      gzip_start;  ///< where the gzip stream begins in the file; none: stored plainly
};

/// Throws InputError if the file is too short for the voxels. `info.extent` has passed check_extent.
std::unique_ptr<VolumeSource> open_array(MappedFile file, const VolumeInfo& info, const ArrayLayout& layout,
                                         Provenance provenance);

}  // namespace cvr::volumes
