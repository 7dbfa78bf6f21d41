// Voxels of HDF5 arrays as they lie in memory there: put in our order of axes and into our types.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "volumes/volume.hpp"

namespace cvr::volumes {

/// How a stored type becomes a voxel type: as it is, or as labels that are checked one by one.
struct Hdf5Conversion {
  bool is_float = false, is_signed = false;
  unsigned width = 1;  ///< stored bytes
  VoxelType type = VoxelType::kU8;
};

/// A part of a read box, as it comes from the file.
struct Hdf5Part {
  const std::byte* stored;
  std::array<std::uint64_t, 3> strides;  ///< along x, y, z, in stored voxels
  Box box;                               ///< its place in the volume
};

/// Writes a part to its place in `out`, which holds the voxels of `whole`, x fastest. Throws
/// InputError for a negative label, and for one that is no whole number or too large to be exact in
/// its stored type, with its voxel.
void place_hdf5_part(const std::string& file, const std::string& position,
                     const Hdf5Conversion& conversion, const Hdf5Part& part, const Box& whole,
                     std::byte* out);

}  // namespace cvr::volumes
