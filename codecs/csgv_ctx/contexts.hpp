// What the symbol of a node is conditioned on: everything a decoder knows when it comes to it
// (FORMAT.md, "Contexts").
//
// The static part of a context is known for all eight children of a node before the first of them;
// the dynamic part changes from child to child. A child has three candidates, the labels that the
// neighbour operations would copy; one that does not exist counts as the parent's label.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "codecs/csgv/label_grid.hpp"
#include "codecs/csgv/lanes.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgv_ctx {

using csgv::Lanes;

inline constexpr unsigned kStaticBits = 14;
inline constexpr unsigned kDynamicBits = 14;

// Static bits, lowest first.
inline constexpr unsigned kDiffers = 0;  ///< 3: candidate x, y, z is not the parent's label
inline constexpr unsigned kSameOrNone =
    3;  ///< 3: of a candidate that differs: the next axis has the same; else: it does not exist
inline constexpr unsigned kAcross =
    6;  ///< 3: the sibling's candidate along that axis is not the parent's label
inline constexpr unsigned kChild = 9;  ///< 3: the child, x in the lowest bit
inline constexpr unsigned kDepth =
    12;  ///< 2: 0 the finest level, 1 the one above, 2 the next, 3 all coarser

// Dynamic bits.
inline constexpr unsigned kEarlier =
    0;  ///< 7: the earlier sibling at child ^ 1 .. child ^ 7 does not have the parent's label
inline constexpr unsigned kNewestIs =
    7;  ///< 3: of those, the newest one has the label of candidate x, y, z
inline constexpr unsigned kNewestIsLast = 10;  ///< ... of the newest palette entry
inline constexpr unsigned kLastIsKnown =
    11;  ///< the newest palette entry is the parent's label or a candidate's
inline constexpr unsigned kExhausted = 12;  ///< all palette entries of the brick have been used
inline constexpr unsigned kSingle = 13;     ///< one palette entry has been used

/// What a child sees of its earlier siblings, from the mask of all children that do not have the
/// parent's label.
struct Siblings {
  std::array<std::uint8_t, 8> earlier{};  ///< bits kEarlier of child c
  std::array<std::uint8_t, 8> newest{};   ///< of these the newest one, if there is any
};
inline constexpr auto kSiblings = [] {
  std::array<Siblings, 256> table{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    for (unsigned c = 0; c < 8; ++c) {
      for (unsigned k = 1; k < 8; ++k) {
        if ((c ^ k) < c && (mask >> (c ^ k) & 1) != 0)
          table[mask].earlier[c] |= static_cast<std::uint8_t>(1u << (k - 1));
      }
      const unsigned before = mask & ((1u << c) - 1);
      if (before != 0)
        table[mask].newest[c] = static_cast<std::uint8_t>(std::bit_width(before) - 1);
    }
  }
  return table;
}();

/// The static context of a level.
constexpr unsigned depth_of(unsigned level, unsigned levels) {
  return levels - 1 - level < 3 ? levels - 1 - level : 3;
}

/// The children of one node as a coder sees them before the first one.
struct Block {
  std::uint32_t parent;
  std::array<Lanes, 3> candidates;
  std::array<unsigned, 3>
      differs;  ///< masks of the children whose candidate is not the parent's label
  std::array<std::uint64_t, 2> bits;  ///< bytes of the children: static bits 0..5, and 6..8

  unsigned static_bits(unsigned c) const {
    return static_cast<unsigned>(bits[0] >> (8 * c) & 0xff) |
           static_cast<unsigned>(bits[1] >> (8 * c) & 0xff) << kAcross | c << kChild;
  }

  /// ... of all eight.
  Lanes static_bits() const {
    return Lanes::of_bytes(bits[0]) | Lanes::of_bytes(bits[1]) << kAcross |
           Lanes::of_bytes(0x0706050403020100u) << kChild;
  }

  /// Of the node with Morton code n. `parents` and `nodes`: labels of its level and of its
  /// children's level, of which the blocks before n are known; `inside`: largest code of its level;
  /// all_nodes: the brick lies in the volume; level: that of the node.
  static Block at(std::uint32_t n, unsigned level, const std::uint32_t* parents,
                  const std::uint32_t* nodes, std::uint32_t inside, bool all_nodes,
                  const csgv::Validity& validity) {
    Block block;
    block.parent = parents[n];
    const Lanes parent = Lanes::broadcast(block.parent);
    std::array<unsigned, 3> none;
    const auto axis = [&](unsigned a, unsigned low, unsigned high, auto&& combine) {
      const std::uint32_t mask = CVR_MORTON_X << a;
      const bool minus = (n & mask) != 0;
      const std::uint32_t above = shaders::cvr_morton_plus(n, a) & inside;
      const bool plus =
          (n & mask) != (mask & inside) && (all_nodes || validity.children(level, above) != 0);
      const Lanes below = minus ? Lanes::load(nodes + 8 * shaders::cvr_morton_minus(n, a)) : parent;
      block.candidates[a] = combine(below, plus ? parents[above] : block.parent);
      block.differs[a] = ~block.candidates[a].equal(parent) & 0xff;
      none[a] = (minus ? 0 : low) | (plus ? 0 : high);
    };
    axis(0, 0x55, 0xaa,
         [](Lanes minus, std::uint32_t plus) { return Lanes::neighbours_x(minus, plus); });
    axis(1, 0x33, 0xcc,
         [](Lanes minus, std::uint32_t plus) { return Lanes::neighbours_y(minus, plus); });
    axis(2, 0x0f, 0xf0,
         [](Lanes minus, std::uint32_t plus) { return Lanes::neighbours_z(minus, plus); });
    block.bits = {0, 0};
    constexpr std::array<unsigned, 3> kLow{0x55, 0x33, 0x0f};
    for (unsigned a = 0; a < 3; ++a) {
      const unsigned d = block.differs[a];
      const unsigned same =
          d == 0 ? 0 : d & block.candidates[a].equal(block.candidates[(a + 1) % 3]);
      const unsigned across = (d & kLow[a]) << (1u << a) | (d >> (1u << a) & kLow[a]);
      block.bits[0] |= csgv::kSpread[d] << (kDiffers + a) | csgv::kSpread[same | none[a]]
                                                                << (kSameOrNone + a);
      block.bits[1] |= csgv::kSpread[across] << a;
    }
    return block;
  }
};

}  // namespace cvr::codecs::csgv_ctx
