// Which children of a node could be coded as copies of a neighbour: the comparison that all
// encoders of the CSGV families share.
#pragma once

#include <array>

#include "codecs/csgv/label_grid.hpp"
#include "codecs/csgv/lanes.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgv {

/// For each axis the mask of the children of node n (level l - 1) that have the label that a
/// neighbour operation along it copies. `lanes` are the children, `nodes` and `parents` the labels
/// of the levels l and l - 1, `inside` the largest code of level l - 1; plus_exists(m) tells
/// whether node m of level l - 1, inside the brick, can be referred to.
template <class PlusExists>
std::array<unsigned, 3> neighbour_matches(const Lanes& lanes, const std::uint32_t* nodes,
                                          const std::uint32_t* parents, std::uint32_t n,
                                          std::uint32_t inside, PlusExists&& plus_exists) {
  // Lanes whose neighbour exists: children at 0 need a block at -1, children at 1 a block at +1.
  const auto available = [&](unsigned axis, unsigned low, unsigned high) {
    const std::uint32_t mask = CVR_MORTON_X << axis;
    const bool minus = (n & mask) != 0;
    const bool plus =
        (n & mask) != (mask & inside) && plus_exists(shaders::cvr_morton_plus(n, axis));
    return (minus ? low : 0u) | (plus ? high : 0u);
  };
  const auto minus = [&](unsigned axis) {
    const bool exists = (n & (CVR_MORTON_X << axis)) != 0;
    return Lanes::load(nodes + 8 * (exists ? shaders::cvr_morton_minus(n, axis) : n));
  };
  const auto plus = [&](unsigned axis) {
    return parents[shaders::cvr_morton_plus(n, axis) & inside];
  };
  return {available(0, 0x55, 0xaa) & lanes.equal(Lanes::neighbours_x(minus(0), plus(0))),
          available(1, 0x33, 0xcc) & lanes.equal(Lanes::neighbours_y(minus(1), plus(1))),
          available(2, 0x0f, 0xf0) & lanes.equal(Lanes::neighbours_z(minus(2), plus(2)))};
}

}  // namespace cvr::codecs::csgv
