// Walks over query points brick by brick for the random-access formats: one loop, no virtual call a
// point.
#pragma once

#include <bit>

#include "codecs/csgv/brick_layout.hpp"
#include "codecs/csgv/reconstruct.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgvr {

/// Calls query(words of the brick's group, place of the brick in its group, Morton code of the node
/// at `level` that contains the point, label) for each point; query returns false where the brick's
/// bytes are none that an encoder writes.
template <class Query>
csgv::BrickError for_each_point(const csgv::BrickLayout& layout, std::span<const Coordinate> points,
                                unsigned level, std::span<std::uint64_t> labels, Query&& query) {
  const unsigned brick_shift = layout.levels - 1;
  const unsigned node_shift = layout.levels - 1 - level;
  const std::uint64_t inside = layout.brick - 1;
  // Groups of several bricks have a power of two per side.
  const auto group_shift = static_cast<unsigned>(std::countr_zero(layout.group));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Coordinate& p = points[i];
    const Coordinate brick{p.x >> brick_shift, p.y >> brick_shift, p.z >> brick_shift};
    const std::uint64_t group = layout.group_index(
        {brick.x >> group_shift, brick.y >> group_shift, brick.z >> group_shift});
    const std::uint32_t member = group_shift == 0 ? 0 : layout.member(brick);
    const auto node = [&](std::uint64_t at) {
      return static_cast<std::uint32_t>((at & inside) >> node_shift);
    };
    const std::uint32_t n = shaders::cvr_morton_encode(node(p.x), node(p.y), node(p.z));
    if (!query(layout.group_words(group), member, n, labels[i]))
      return "a chain of operations leaves its brick or its palette";
  }
  return nullptr;
}

}  // namespace cvr::codecs::csgvr
