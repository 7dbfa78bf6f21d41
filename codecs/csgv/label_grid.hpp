// The label multigrid of one brick (CSGV-R paper, section 2.5; rules of ties and borders in
// FORMAT.md).
//
// Level 0 is the coarsest (one node), level L-1 has b^3 nodes. Nodes of a level lie in Morton
// order, so the 8 children of node n are nodes 8n .. 8n+7 of the next level. A node's label is the
// most frequent of its valid children, ties going to the first in child order. A node is constant
// when all its valid children have the same label and are constant themselves; nodes of the finest
// level are not asked. A brick at the border of the volume may have nodes outside: they do not
// vote.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "volumes/volume.hpp"

namespace cvr::codecs::csgv {

inline constexpr unsigned kMaxLevels = 7;  ///< b = 64

/// Nodes of level l, and of all levels before l.
constexpr std::uint32_t nodes_of_level(unsigned l) { return std::uint32_t{1} << (3 * l); }
constexpr std::uint32_t nodes_before_level(unsigned l) { return (nodes_of_level(l) - 1) / 7; }

/// Levels of a brick with b voxels per side.
constexpr unsigned levels_of_brick(std::uint32_t b) {
  unsigned levels = 1;
  while ((std::uint32_t{1} << (levels - 1)) < b) ++levels;
  return levels;
}

/// How much of a brick lies inside the volume: 1..b voxels per axis.
struct BrickExtent {
  std::uint32_t x, y, z;
  bool operator==(const BrickExtent&) const = default;
};

/// Which nodes of a brick lie inside the volume.
class Validity {
 public:
  Validity(std::uint32_t b, const BrickExtent& extent);
  bool whole() const { return whole_; }
  /// Valid nodes of a level along the axes.
  const BrickExtent& nodes(unsigned level) const { return nodes_[level]; }
  /// Mask of the valid children (at level + 1) of the node with Morton code n at `level`.
  unsigned children(unsigned level, std::uint32_t n) const;

 private:
  bool whole_;
  std::array<BrickExtent, kMaxLevels> nodes_;
};

/// Labels of all nodes of one brick. Reused from brick to brick; one per thread.
class LabelGrid {
 public:
  explicit LabelGrid(std::uint32_t b);
  std::uint32_t brick() const { return brick_; }
  unsigned levels() const { return levels_; }

  std::uint32_t* labels(unsigned level) { return labels_.data() + offset(level); }
  const std::uint32_t* labels(unsigned level) const { return labels_.data() + offset(level); }
  /// Mask of the constant children of node n of a level < L-2; at L-2 all children count as not
  /// constant.
  unsigned constant_children(unsigned level, std::uint32_t n) const {
    return constant_[offset(level) + n];
  }
  bool constant() const { return constant_root_; }

  /// Fills the finest level from voxels (x fastest, rows `row` and planes `plane` voxels apart) and
  /// builds all coarser levels. T: u8, u16 or u32.
  template <class T>
  void build(const T* voxels, std::uint64_t row, std::uint64_t plane, const Validity& validity);

  /// Gives every node outside the volume its parent's label and makes nodes whose subtree lies
  /// outside constant, as the random-access formats need, which keep all nodes.
  void fill_outside(const Validity& validity);

  /// Copies a level's valid nodes to voxels, x fastest, rows `row` and planes `plane` apart.
  template <class T>
  void scatter(unsigned level, const BrickExtent& nodes, T* voxels, std::uint64_t row,
               std::uint64_t plane) const;

 private:
  // Levels start at multiples of 8 labels, so that a block never straddles more cache lines than it
  // must.
  static constexpr std::uint32_t offset(unsigned level) {
    return level == 0 ? 0 : nodes_before_level(level) - 1 + 8;
  }

  template <class T>
  bool gather_whole(const T* voxels, std::uint64_t row, std::uint64_t plane);
  template <class T>
  void gather_partial(const T* voxels, std::uint64_t row, std::uint64_t plane,
                      const Validity& validity);
  void build_coarser(const Validity& validity);
  void fill_constant(std::uint32_t label);

  std::uint32_t brick_;
  unsigned levels_;
  bool constant_root_ = false;
  std::vector<std::uint32_t> labels_;
  std::vector<std::uint8_t> constant_;
};

}  // namespace cvr::codecs::csgv
