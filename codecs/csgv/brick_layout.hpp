// Where the bricks of a payload of the CSGV kind lie. Bricks are stored in groups of up to group^3,
// groups x fastest; of the published formats each brick is a group of its own.
#pragma once

#include <cstdint>
#include <span>

#include "codecs/codec.hpp"
#include "codecs/csgv/label_grid.hpp"

namespace cvr::codecs::csgv {

/// A brick among the words of its group.
struct StoredBrick {
  std::span<const std::uint32_t> words;
  std::uint32_t member;  ///< its place in the group, x fastest
  std::uint32_t bricks;  ///< of the group
};

struct BrickLayout {
  BrickLayout(const Extent& volume, std::uint32_t brick_edge, std::uint32_t group_edge);

  std::uint32_t brick;  ///< voxels per side
  std::uint32_t group;  ///< bricks per side of a group
  unsigned levels;
  Extent extent;                          ///< of the volume
  Extent grid;                            ///< bricks along each axis
  Extent groups;                          ///< groups along each axis
  const std::uint32_t* starts = nullptr;  ///< of each group and the end, in words from `words`
  const std::uint32_t* words = nullptr;

  std::uint64_t index(const Coordinate& c) const { return c.x + grid.x * (c.y + grid.y * c.z); }
  /// The group of a brick, and the bricks of a group along each axis: fewer at the volume's border.
  Coordinate group_at(const Coordinate& c) const { return {c.x / group, c.y / group, c.z / group}; }
  std::uint64_t group_index(const Coordinate& g) const {
    return g.x + groups.x * (g.y + groups.y * g.z);
  }
  Extent bricks_of_group(const Coordinate& g) const;
  /// A brick's place in its group, x fastest.
  std::uint32_t member(const Coordinate& c) const;
  StoredBrick stored(const Coordinate& brick) const;
  std::span<const std::uint32_t> group_words(std::uint64_t i) const {
    return {words + starts[i], words + starts[i + 1]};
  }
  BrickExtent brick_extent(const Coordinate& c) const;
};

}  // namespace cvr::codecs::csgv
