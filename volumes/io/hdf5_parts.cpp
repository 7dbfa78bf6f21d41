#include "volumes/io/hdf5_parts.hpp"

#include <algorithm>

namespace cvr::volumes {

std::vector<Box> plan_parts(const Box& box, const ChunkedArray& array, std::uint64_t most_bytes) {
  const std::array<std::uint64_t, 3> origin{box.origin.x, box.origin.y, box.origin.z};
  const std::array<std::uint64_t, 3> end{origin[0] + box.size.x, origin[1] + box.size.y,
                                         origin[2] + box.size.z};
  std::array<std::uint64_t, 3> part = array.chunk;
  const auto longest = [&](std::size_t axis) {
    const std::uint64_t rest = part[0] * part[1] * part[2] / part[axis] * array.voxel_bytes;
    return std::max<std::uint64_t>(most_bytes / rest, 1);
  };
  for (const std::size_t axis : array.slowest_first)
    part[axis] = std::min(part[axis], longest(axis));
  std::array<std::uint64_t, 3> first = origin;  // of the parts, which begin where chunks do
  for (std::size_t i = 3; i-- > 0;) {
    const std::size_t axis = array.slowest_first[i];
    first[axis] -= origin[axis] % part[axis];
    const std::uint64_t chunks = (end[axis] - first[axis] + part[axis] - 1) / part[axis];
    part[axis] *= std::min(chunks, longest(axis) / part[axis]);
  }
  const auto next = [&](std::size_t axis, std::uint64_t at) {
    const std::uint64_t parts = (at - first[axis]) / part[axis] + 1;
    return std::min(first[axis] + parts * part[axis], end[axis]);
  };
  std::vector<Box> parts;
  for (std::uint64_t z = origin[2]; z < end[2]; z = next(2, z)) {
    for (std::uint64_t y = origin[1]; y < end[1]; y = next(1, y)) {
      for (std::uint64_t x = origin[0]; x < end[0]; x = next(0, x))
        parts.push_back({{x, y, z}, {next(0, x) - x, next(1, y) - y, next(2, z) - z}});
    }
  }
  return parts;
}

}  // namespace cvr::volumes
