// Coordinates of bricks and groups.
#include "codecs/csgv/brick_layout.hpp"

#include <algorithm>

namespace cvr::codecs::csgv {

BrickLayout::BrickLayout(const Extent& volume, std::uint32_t brick_edge, std::uint32_t group_edge)
    : brick(brick_edge),
      group(group_edge),
      levels(levels_of_brick(brick_edge)),
      extent(volume),
      grid(volumes::ceil_div(volume, brick_edge)),
      groups(volumes::ceil_div(grid, group_edge)) {}

Extent BrickLayout::bricks_of_group(const Coordinate& g) const {
  const auto cut = [this](std::uint64_t at, std::uint64_t size) {
    return std::min<std::uint64_t>(group, size - at * group);
  };
  return {cut(g.x, grid.x), cut(g.y, grid.y), cut(g.z, grid.z)};
}

std::uint32_t BrickLayout::member(const Coordinate& c) const {
  const Extent bricks = bricks_of_group(group_at(c));
  return static_cast<std::uint32_t>(c.x % group +
                                    bricks.x * (c.y % group + bricks.y * (c.z % group)));
}

StoredBrick BrickLayout::stored(const Coordinate& c) const {
  const Coordinate g = group_at(c);
  return {group_words(group_index(g)), member(c),
          static_cast<std::uint32_t>(bricks_of_group(g).voxels())};
}

BrickExtent BrickLayout::brick_extent(const Coordinate& c) const {
  const auto cut = [this](std::uint64_t at, std::uint64_t size) {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(brick, size - at * brick));
  };
  return {cut(c.x, extent.x), cut(c.y, extent.y), cut(c.z, extent.z)};
}

}  // namespace cvr::codecs::csgv
