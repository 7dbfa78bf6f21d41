// From a label multigrid to the operations that rebuild it, level by level in Morton order (CSGV-R
// paper, section 2.5).
//
// A symbol is one byte: bits 0..2 the operation, bit 3 the stop bit. The first operation that fits
// is taken, in the order parent, neighbour x, y, z, last, delta (if enabled), advance. A neighbour
// is the node beside the own 2x2x2 block: at -1 of the same level for children at 0, at +1 of the
// parent's level for children at 1. Below a node with a stop bit nothing is coded.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codecs/csgv/label_grid.hpp"
#include "codecs/csgv/palette_index.hpp"

namespace cvr::codecs::csgv {

enum Operation : std::uint8_t {
  kParent = 0,
  kNeighbourX = 1,
  kNeighbourY = 2,
  kNeighbourZ = 3,
  kAdvance = 4,
  kLast = 5,
  kDelta = 6,
};
inline constexpr std::uint8_t kStopBit = 8;

struct OperationOptions {
  bool stop_bits;  ///< leave out what lies below constant nodes
  bool
      keep_outside;  ///< also code nodes outside the volume (random access needs every node in its place)
  bool
      delta;  ///< refer to older palette entries; the distance follows as base-8 digits, bit 3 = more follow
};

/// The operations of one brick. Reused from brick to brick; one per thread.
class OperationStream {
 public:
  explicit OperationStream(std::uint32_t b);

  /// With options.keep_outside the grid must have had fill_outside().
  void encode(const LabelGrid& grid, const Validity& validity, const OperationOptions& options);

  unsigned levels() const { return levels_; }
  std::span<const std::uint8_t> symbols() const { return {symbols_.data(), level_start_[levels_]}; }
  /// Index of the first symbol of a level; level_start(levels()) is the number of symbols.
  std::uint32_t level_start(unsigned level) const { return level_start_[level]; }
  std::span<const std::uint32_t> palette() const { return {palette_.data(), palette_size_}; }

 private:
  struct Block;
  template <bool kStops, bool kDeltas>
  void encode_levels(const LabelGrid& grid, const Validity& validity,
                     const OperationOptions& options);
  template <bool kDeltas>
  std::uint64_t palette_operations(const std::uint32_t* labels, unsigned lanes);
  void append_with_digits(std::uint64_t codes, unsigned valid);

  unsigned levels_;
  std::array<std::uint32_t, kMaxLevels + 1> level_start_{};
  std::uint8_t* end_ = nullptr;  ///< where the next symbol goes
  std::uint32_t palette_size_ = 0;
  std::vector<std::uint8_t> symbols_;
  std::vector<std::uint32_t> palette_;
  std::array<std::vector<std::uint32_t>, 2>
      active_;          ///< nodes of this level and the next that have coded children
  PaletteIndex index_;  ///< for delta
  std::array<std::uint32_t, 8> distances_{};  ///< of the delta operations of the current block
};

}  // namespace cvr::codecs::csgv
