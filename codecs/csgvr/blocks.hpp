// The 2x2x2 blocks of a brick as `csgvr-c` codes them: for each open node, coarsest level first and
// in Morton order, what may be said of its eight children. Which of several neighbours with the
// same label is named is left to the code (block_code.hpp).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "codecs/csgv/label_grid.hpp"
#include "codecs/csgv/neighbour_matches.hpp"

namespace cvr::codecs::csgvr {

/// The operations of the 8 children, 3 bits each: 4 a label of its own, 5 the last such label of
/// the block again.
using BlockOperations = std::uint32_t;

/// The bits of a mask, three apart.
inline constexpr auto kSpread3 = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t mask = 0; mask < 256; ++mask) {
    for (unsigned c = 0; c < 8; ++c) table[mask] |= (mask >> c & 1) << (3 * c);
  }
  return table;
}();

inline constexpr std::array<std::array<unsigned, 3>, 6> kAxisOrders{
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

/// What a block can be coded as: masks of its children. Those in none of x, y, z, own have the
/// parent's label.
class BlockShape {
 public:
  BlockShape() = default;
  /// x, y, z: have the label of the neighbour along the axis, not the parent's; own: have
  /// neither's; repeated: those of `own` with the label of the last of them.
  BlockShape(const std::array<unsigned, 3>& axes, unsigned own, unsigned repeated)
      : bits_(axes[0] | axes[1] << 8 | axes[2] << 16 | own << 24 | std::uint64_t{repeated} << 32) {}

  static BlockShape from_bits(std::uint64_t bits) {
    BlockShape shape;
    shape.bits_ = bits;
    return shape;
  }
  std::uint64_t bits() const { return bits_; }
  unsigned axis(unsigned a) const { return bits_ >> (8 * a) & 0xff; }
  unsigned own() const { return bits_ >> 24 & 0xff; }
  unsigned repeated() const { return bits_ >> 32 & 0xff; }
  /// Places in kAxisOrders, without the first, of orders that may name other neighbours: none where
  /// no child matches two axes.
  std::span<const unsigned> other_orders() const;

  /// The axis that most children match first, then the one that most of the others match.
  std::array<unsigned, 3> widest_first() const {
    std::array<unsigned, 3> order{0, 1, 2};
    unsigned named = 0;
    for (unsigned i = 0; i < 2; ++i) {
      for (unsigned k = i + 1; k < 3; ++k) {
        if (std::popcount(axis(order[k]) & ~named) > std::popcount(axis(order[i]) & ~named))
          std::swap(order[i], order[k]);
      }
      named |= axis(order[i]);
    }
    return order;
  }

  /// The operations where children that match several axes name the first of this order.
  BlockOperations operations(const std::array<unsigned, 3>& order) const {
    BlockOperations operations = kSpread3[own()] << 2 | kSpread3[repeated()];
    unsigned named = 0;
    for (const unsigned a : order) {
      operations |= kSpread3[axis(a) & ~named] * (1 + a);
      named |= axis(a);
    }
    return operations;
  }

 private:
  std::uint64_t bits_ = 0;
};

inline std::span<const unsigned> BlockShape::other_orders() const {
  static constexpr std::array<unsigned, 5> kAll{1, 2, 3, 4, 5}, kYBeforeX{2}, kZBeforeX{4},
      kZBeforeY{1};
  const bool xy = (axis(0) & axis(1)) != 0;
  const bool xz = (axis(0) & axis(2)) != 0;
  const bool yz = (axis(1) & axis(2)) != 0;
  switch ((xy ? 1 : 0) + (xz ? 1 : 0) + (yz ? 1 : 0)) {
    case 0:
      return {};
    case 1:
      return std::span(xy ? kYBeforeX : xz ? kZBeforeX : kZBeforeY).first(1);
    default:
      return kAll;
  }
}

/// Finds the blocks of one brick after the other; one per thread.
class BlockFinder {
 public:
  explicit BlockFinder(std::uint32_t b)
      : active_(csgv::nodes_of_level(csgv::levels_of_brick(b) - 2)), next_(active_.size()) {}

  /// body(finest, shape, mask of open children, labels of the 8 children) for each block of a grid
  /// whose nodes outside the volume are filled.
  template <class Body>
  void run(const csgv::LabelGrid& grid, Body&& body) {
    std::uint32_t count = grid.constant() ? 0 : 1;
    active_[0] = 0;
    for (unsigned l = 1; l < grid.levels(); ++l) {
      const bool finest = l + 1 == grid.levels();
      std::uint32_t next_count = 0;
      for (std::uint32_t k = 0; k < count; ++k) {
        const std::uint32_t n = active_[k];
        const unsigned open = finest ? 0 : ~grid.constant_children(l - 1, n) & 0xff;
        body(finest, shape_of(grid, l, n), open, grid.labels(l) + 8 * n);
        for (unsigned rest = open; rest != 0; rest &= rest - 1) {
          next_[next_count++] = 8 * n + static_cast<std::uint32_t>(std::countr_zero(rest));
        }
      }
      std::swap(active_, next_);
      count = next_count;
    }
  }

 private:
  static BlockShape shape_of(const csgv::LabelGrid& grid, unsigned l, std::uint32_t n) {
    const std::uint32_t* nodes = grid.labels(l);
    const std::uint32_t* parents = grid.labels(l - 1);
    const csgv::Lanes lanes = csgv::Lanes::load(nodes + 8 * n);
    const unsigned differs = ~lanes.equal(csgv::Lanes::broadcast(parents[n])) & 0xff;
    if (differs == 0) return {};
    auto axes = csgv::neighbour_matches(lanes, nodes, parents, n, csgv::nodes_of_level(l - 1) - 1,
                                        [](std::uint32_t) { return true; });
    for (unsigned& mask : axes) mask &= differs;
    const unsigned own = differs & ~(axes[0] | axes[1] | axes[2]);
    unsigned repeated = 0;
    std::uint32_t last = 0;
    for (unsigned rest = own; rest != 0; rest &= rest - 1) {
      const auto c = static_cast<unsigned>(std::countr_zero(rest));
      if (rest != own && nodes[8 * n + c] == last) repeated |= 1u << c;
      last = nodes[8 * n + c];
    }
    return {axes, own, repeated};
  }

  std::vector<std::uint32_t> active_, next_;  ///< open nodes of this level and the next
};

}  // namespace cvr::codecs::csgvr
