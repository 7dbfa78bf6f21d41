// In which parts a box of a chunked HDF5 array is read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "volumes/volume.hpp"

namespace cvr::volumes {

struct ChunkedArray {
  std::array<std::uint64_t, 3> chunk;        ///< voxels along x, y, z, at least 1
  std::array<std::size_t, 3> slowest_first;  ///< 0, 1, 2 for x, y, z, in the order of the file
  std::uint64_t voxel_bytes;                 ///< as stored
};

/// Parts of `box` of at most `most_bytes` each (at least a voxel), which together are the box, in
/// the order z, y, x. They are made of whole chunks, cut by the box alone, so that none is inflated
/// for two parts, and of as many as can be along the file's fast axes. A chunk of more than
/// `most_bytes` is cut along its slow axes. Chunks begin at multiples of their size.
std::vector<Box> plan_parts(const Box& box, const ChunkedArray& array, std::uint64_t most_bytes);

}  // namespace cvr::volumes
