// From operations back to the labels of one brick, serially, level by level (CSGV-R paper, section
// 2.5): the decoder that both families share. A Reader hands out symbols; it never reads beyond its
// brick, whatever the bytes are.
//
// Reader:
//   void begin_level(unsigned level, bool finest)           before the first symbol of each level >= 1
//   bool take(unsigned count, std::uint64_t& codes)         the next 1..8 symbols as bytes, first lowest; false at the end
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "codecs/csgv/label_grid.hpp"
#include "codecs/csgv/lanes.hpp"
#include "codecs/csgv/operations.hpp"
#include "shaders/shared/shared.hpp"

namespace cvr::codecs::csgv {

/// A palette as bricks store it: entry k is the k-th word from the brick's end.
struct ReversedPalette {
  const std::uint32_t* last;  ///< entry 0
  std::uint32_t size;
  std::uint32_t operator[](std::uint32_t k) const { return *(last - k); }
};

/// What is wrong with a brick, or nullptr.
using BrickError = const char*;

/// Rebuilds the levels 0..target of `grid` (finer levels are undefined afterwards).
/// Palette: `size`, and the label of entry k < size.
template <class Reader, class Palette = ReversedPalette>
class Reconstruction {
 public:
  Reconstruction(Reader& reader, const Palette& palette, LabelGrid& grid, const Validity& validity,
                 const OperationOptions& options)
      : reader_(reader),
        palette_(palette),
        grid_(grid),
        validity_(validity),
        options_(options),
        all_nodes_(options.keep_outside || validity.whole()) {}

  /// `active` holds two lists of nodes_of_level(levels - 2) nodes each.
  BrickError run(unsigned target, std::uint32_t* active, std::uint32_t* next);

 private:
  BrickError start(unsigned target, bool& stopped);
  BrickError block(unsigned l, std::uint32_t n, unsigned valid, std::uint64_t codes);
  bool take_with_digits(unsigned valid, std::uint64_t& codes);
  void fill_below(unsigned level, std::uint32_t n, unsigned target);

  Reader& reader_;
  Palette palette_;
  LabelGrid& grid_;
  const Validity& validity_;
  OperationOptions options_;
  bool all_nodes_;
  std::uint32_t entries_ = 0;  ///< palette entries used so far
  std::uint32_t distances_[8] = {};
};

/// Spreads the low bits of `codes` (one byte for each set bit of `valid`) to the lanes of `valid`.
inline std::uint64_t expand_to_lanes(std::uint64_t codes, unsigned valid) {
  std::uint64_t spread = 0;
  for (; valid != 0; valid &= valid - 1, codes >>= 8)
    spread |= (codes & 0xff) << (8 * std::countr_zero(valid));
  return spread;
}

template <class Reader, class Palette>
BrickError Reconstruction<Reader, Palette>::start(unsigned target, bool& stopped) {
  std::uint64_t root = 0;
  if (!reader_.take(1, root)) return "the operations end early";
  if ((root & 7) != kAdvance) return "the first operation is not 'palette advance'";
  if (palette_.size == 0) return "the palette is empty";
  grid_.labels(0)[0] = palette_[0];
  entries_ = 1;
  stopped = options_.stop_bits && (root & kStopBit) != 0;
  if (stopped) fill_below(0, 0, target);
  return nullptr;
}

/// Nodes below a node lie side by side in every finer level.
template <class Reader, class Palette>
void Reconstruction<Reader, Palette>::fill_below(unsigned level, std::uint32_t n, unsigned target) {
  const std::uint32_t label = grid_.labels(level)[n];
  for (unsigned l = level + 1; l <= target; ++l) {
    const std::uint32_t count = nodes_of_level(l - level);
    std::fill_n(grid_.labels(l) + std::size_t{n} * count, count, label);
  }
}

/// With deltas the digits stand between the symbols: one at a time. A leading zero digit ends the
/// brick: no encoder writes it, and entropy-coded ones could go on for billions of digits in a few
/// bytes.
template <class Reader, class Palette>
bool Reconstruction<Reader, Palette>::take_with_digits(unsigned valid, std::uint64_t& codes) {
  codes = 0;
  for (; valid != 0; valid &= valid - 1) {
    const auto c = static_cast<unsigned>(std::countr_zero(valid));
    std::uint64_t symbol = 0;
    if (!reader_.take(1, symbol)) return false;
    codes |= symbol << (8 * c);
    if ((symbol & 7) != kDelta) continue;
    std::uint64_t distance = 0;
    for (std::uint64_t digit = kStopBit; (digit & kStopBit) != 0;) {
      if (!reader_.take(1, digit) || distance > palette_.size) return false;
      distance = distance << 3 | (digit & 7);
      if (distance == 0 && (digit & kStopBit) != 0) return false;
    }
    distances_[c] = static_cast<std::uint32_t>(distance + 1);
  }
  return true;
}

/// Labels of the children of node n of level l-1.
template <class Reader, class Palette>
BrickError Reconstruction<Reader, Palette>::block(unsigned l, std::uint32_t n, unsigned valid,
                                                  std::uint64_t codes) {
  const std::uint32_t* parents = grid_.labels(l - 1);
  std::uint32_t* nodes = grid_.labels(l);
  const std::uint64_t operations = codes & 0x0707070707070707u;
  Lanes lanes = Lanes::broadcast(parents[n]);
  if (operations != 0) {
    const std::uint32_t inside = nodes_of_level(l - 1) - 1;
    unsigned impossible = 0;
    const auto neighbours = [&](unsigned axis, unsigned low, unsigned high, auto&& combine) {
      const std::uint32_t mask = CVR_MORTON_X << axis;
      const bool minus = (n & mask) != 0;
      const std::uint32_t above = shaders::cvr_morton_plus(n, axis) & inside;
      const bool plus =
          (n & mask) != (mask & inside) && (all_nodes_ || validity_.children(l - 1, above) != 0);
      const std::uint64_t differs = operations ^ (0x0101010101010101u * (kNeighbourX + axis));
      // Bytes of `differs` that are zero: all three low bits clear.
      const unsigned here = gather_low_bits(~(differs | differs >> 1 | differs >> 2));
      impossible |= here & ~((minus ? low : 0u) | (plus ? high : 0u));
      const Lanes beside =
          Lanes::load(nodes + 8 * (minus ? shaders::cvr_morton_minus(n, axis) : n));
      lanes = lanes.replaced(combine(beside, parents[above]), Lanes::where(here));
    };
    neighbours(0, 0x55, 0xaa,
               [](Lanes minus, std::uint32_t plus) { return Lanes::neighbours_x(minus, plus); });
    neighbours(1, 0x33, 0xcc,
               [](Lanes minus, std::uint32_t plus) { return Lanes::neighbours_y(minus, plus); });
    neighbours(2, 0x0f, 0xf0,
               [](Lanes minus, std::uint32_t plus) { return Lanes::neighbours_z(minus, plus); });
    if ((impossible & valid) != 0) return "a neighbour operation leaves the brick";
  }
  lanes.store(nodes + 8 * n);
  // Palette operations are those with bit 2.
  for (unsigned palette = gather_low_bits(operations >> 2) & valid; palette != 0;
       palette &= palette - 1) {
    const auto c = static_cast<unsigned>(std::countr_zero(palette));
    std::uint32_t entry = entries_ - 1;
    switch (operations >> (8 * c) & 7) {
      case kAdvance:
        if (entries_ >= palette_.size) return "more palette operations than palette entries";
        entry = entries_++;
        break;
      case kLast:
        break;
      case kDelta:
        if (!options_.delta || distances_[c] >= entries_)
          return "a palette distance leaves the palette";
        entry -= distances_[c];
        break;
      default:
        return "an unknown operation";
    }
    nodes[8 * n + c] = palette_[entry];
  }
  return nullptr;
}

template <class Reader, class Palette>
BrickError Reconstruction<Reader, Palette>::run(unsigned target, std::uint32_t* active,
                                                std::uint32_t* next) {
  bool stopped = false;
  if (BrickError error = start(target, stopped)) return error;
  std::uint32_t active_count = stopped ? 0 : 1;
  active[0] = 0;
  for (unsigned l = 1; l <= target && active_count > 0; ++l) {
    const bool finest = l + 1 == grid_.levels();
    reader_.begin_level(l, finest);
    std::uint32_t next_count = 0;
    for (std::uint32_t k = 0; k < active_count; ++k) {
      const std::uint32_t n = active[k];
      const unsigned valid = all_nodes_ ? 0xff : validity_.children(l - 1, n);
      std::uint64_t codes = 0;
      if (options_.delta) {
        if (!take_with_digits(valid, codes)) return "the operations end early";
      } else {
        if (!reader_.take(static_cast<unsigned>(std::popcount(valid)), codes))
          return "the operations end early";
        if (valid != 0xff) codes = expand_to_lanes(codes, valid);
      }
      if (BrickError error = block(l, n, valid, codes)) return error;
      if (finest) continue;
      const unsigned stops = options_.stop_bits ? gather_low_bits(codes >> 3) & valid : 0;
      for (unsigned rest = stops; rest != 0; rest &= rest - 1) {
        fill_below(l, 8 * n + static_cast<std::uint32_t>(std::countr_zero(rest)), target);
      }
      for (unsigned open = valid & ~stops; open != 0; open &= open - 1) {
        next[next_count++] = 8 * n + static_cast<std::uint32_t>(std::countr_zero(open));
      }
    }
    std::swap(active, next);
    active_count = next_count;
  }
  return nullptr;
}

}  // namespace cvr::codecs::csgv
