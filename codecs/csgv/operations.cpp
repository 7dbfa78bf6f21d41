#include "codecs/csgv/operations.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "codecs/csgv/lanes.hpp"
#include "codecs/csgv/neighbour_matches.hpp"

namespace cvr::codecs::csgv {

namespace {

constexpr unsigned kMaxDeltaSymbols = 8;  // the operation and at most seven base-8 digits

}  // namespace

OperationStream::OperationStream(std::uint32_t b) : levels_(levels_of_brick(b)) {
  symbols_.resize(nodes_before_level(levels_) + 8);
  palette_.resize(nodes_before_level(levels_));
  for (auto& nodes : active_) nodes.resize(nodes_of_level(levels_ - 2));
}

void OperationStream::encode(const LabelGrid& grid, const Validity& validity,
                             const OperationOptions& options) {
  if (options.delta) {
    symbols_.resize(kMaxDeltaSymbols * nodes_before_level(levels_) + 8);
    index_.begin(nodes_of_level(levels_ - 1));
  }
  if (options.stop_bits) {
    options.delta ? encode_levels<true, true>(grid, validity, options)
                  : encode_levels<true, false>(grid, validity, options);
  } else {
    encode_levels<false, false>(grid, validity, options);
  }
}

/// The palette operations of the given lanes, as bytes.
template <bool kDeltas>
std::uint64_t OperationStream::palette_operations(const std::uint32_t* labels, unsigned lanes) {
  std::uint64_t codes = 0;
  for (; lanes != 0; lanes &= lanes - 1) {
    const auto c = static_cast<unsigned>(std::countr_zero(lanes));
    const std::uint32_t label = labels[c];
    std::uint64_t operation = kAdvance;
    if (palette_[palette_size_ - 1] == label) {
      operation = kLast;
    } else if (const std::uint32_t entry =
                   kDeltas ? index_.find_or_add(label, palette_size_) : PaletteIndex::kNone;
               entry != PaletteIndex::kNone) {
      operation = kDelta;
      distances_[c] = palette_size_ - 1 - entry;
    } else {
      palette_[palette_size_++] = label;
    }
    codes |= operation << (8 * c);
  }
  return codes;
}

/// Appends the symbols of a block; after each delta operation its distance, minus one, in base 8, highest digit first.
void OperationStream::append_with_digits(std::uint64_t codes, unsigned valid) {
  for (unsigned c = 0; c < 8; ++c) {
    if ((valid >> c & 1) == 0) continue;
    const auto symbol = static_cast<std::uint8_t>(codes >> (8 * c));
    *end_++ = symbol;
    if ((symbol & 7) != kDelta) continue;
    const std::uint32_t distance = distances_[c] - 1;
    unsigned shift = 0;
    while (distance >> shift >= 8) shift += 3;
    for (;; shift -= 3) {
      *end_++ = static_cast<std::uint8_t>((distance >> shift & 7) | (shift > 0 ? kStopBit : 0));
      if (shift == 0) break;
    }
  }
}

template <bool kStops, bool kDeltas>
void OperationStream::encode_levels(const LabelGrid& grid, const Validity& validity,
                                    const OperationOptions& options) {
  const bool all_nodes = options.keep_outside || validity.whole();
  end_ = symbols_.data();
  palette_[0] = grid.labels(0)[0];
  palette_size_ = 1;
  if constexpr (kDeltas) index_.find_or_add(palette_[0], 0);
  const bool stop_root = kStops && grid.constant();
  *end_++ = static_cast<std::uint8_t>(kAdvance | (stop_root ? kStopBit : 0));
  level_start_[0] = 0;
  std::uint32_t* active = active_[0].data();
  std::uint32_t* next = active_[1].data();
  std::uint32_t active_count = stop_root ? 0 : 1;
  active[0] = 0;

  for (unsigned l = 1; l < levels_; ++l) {
    level_start_[l] = static_cast<std::uint32_t>(end_ - symbols_.data());
    const std::uint32_t* parents = grid.labels(l - 1);
    const std::uint32_t* nodes = grid.labels(l);
    const std::uint32_t inside = nodes_of_level(l - 1) - 1;
    const bool stops = kStops && l + 1 < levels_;
    std::uint32_t next_count = 0;
    for (std::uint32_t k = 0; k < active_count; ++k) {
      const std::uint32_t n = active[k];
      const std::uint32_t* block = nodes + 8 * n;
      const unsigned valid = all_nodes ? 0xff : validity.children(l - 1, n);
      const Lanes lanes = Lanes::load(block);
      unsigned rest = valid & ~lanes.equal(Lanes::broadcast(parents[n]));
      std::uint64_t codes = 0;
      if (rest != 0) {
        const auto [by_x, by_y, by_z] = neighbour_matches(
            lanes, nodes, parents, n, inside,
            [&](std::uint32_t above) { return all_nodes || validity.children(l - 1, above) != 0; });
        const unsigned x = rest & by_x;
        const unsigned y = rest & by_y & ~x;
        const unsigned z = rest & by_z & ~x & ~y;
        rest &= ~(x | y | z);
        codes = kSpread[x] * kNeighbourX | kSpread[y] * kNeighbourY | kSpread[z] * kNeighbourZ |
                palette_operations<kDeltas>(block, rest);
      }
      const unsigned constant = stops ? grid.constant_children(l - 1, n) & valid : 0;
      codes |= kSpread[constant] * kStopBit;
      if (valid == 0xff && !kDeltas) {
        std::memcpy(end_, &codes, sizeof codes);
        end_ += 8;
      } else {
        append_with_digits(codes, valid);
      }
      if (l + 1 == levels_) continue;
      for (unsigned open = valid & ~constant; open != 0; open &= open - 1) {
        next[next_count++] = 8 * n + static_cast<std::uint32_t>(std::countr_zero(open));
      }
    }
    std::swap(active, next);
    active_count = next_count;
  }
  level_start_[levels_] = static_cast<std::uint32_t>(end_ - symbols_.data());
}

}  // namespace cvr::codecs::csgv
