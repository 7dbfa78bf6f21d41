#include "codecs/entropy/rans.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace cvr::codecs::entropy {

RansTable RansTable::fit(const std::array<std::uint64_t, kRansSymbols>& counts,
                         std::uint32_t possible) {
  std::uint64_t total = 0;
  std::uint32_t symbols = 0;
  for (unsigned s = 0; s < kRansSymbols; ++s) {
    if ((possible >> s & 1) == 0) continue;
    total += counts[s];
    ++symbols;
  }
  RansTable table;
  std::uint32_t left = kRansProbabilitySum;
  unsigned most = static_cast<unsigned>(std::countr_zero(possible));
  for (unsigned s = 0; s < kRansSymbols; ++s) {
    if ((possible >> s & 1) == 0) continue;
    // Counts below 2^50 / 2^14: volumes have at most 2^50 voxels, so the product is taken in 128
    // bits.
    const auto share = total == 0
                           ? 0
                           : static_cast<std::uint32_t>(static_cast<unsigned __int128>(counts[s]) *
                                                        (kRansProbabilitySum - symbols) / total);
    table.frequencies_[s] = static_cast<std::uint16_t>(1 + share);
    left -= table.frequencies_[s];
    if (counts[s] > counts[most]) most = s;
  }
  table.frequencies_[most] = static_cast<std::uint16_t>(table.frequencies_[most] + left);
  table.build();
  return table;
}

bool RansTable::from_frequencies(const std::array<std::uint16_t, kRansSymbols>& frequencies,
                                 RansTable& table) {
  std::uint32_t sum = 0;
  for (const std::uint16_t f : frequencies) sum += f;
  if (sum != kRansProbabilitySum) return false;
  table.frequencies_ = frequencies;
  table.build();
  return true;
}

std::vector<std::uint32_t> RansTable::packed_slots() const {
  std::vector<std::uint32_t> slots(kRansProbabilitySum);
  for (std::uint32_t slot = 0; slot < kRansProbabilitySum; ++slot) {
    const std::uint8_t symbol = symbol_of_slot_[slot];
    const Step& step = steps_[symbol];
    slots[slot] = symbol | (step.frequency - 1) << 4 | (slot - step.start) << 18;
  }
  return slots;
}

void RansTable::build() {
  symbol_of_slot_.resize(kRansProbabilitySum);
  std::uint32_t start = 0;
  for (unsigned s = 0; s < kRansSymbols; ++s) {
    const std::uint32_t f = frequencies_[s];
    std::fill_n(symbol_of_slot_.begin() + start, f, static_cast<std::uint8_t>(s));
    if (f > 0) {
      const auto shift = static_cast<std::uint32_t>(std::bit_width(f - 1));
      steps_[s] = {.reciprocal = ((std::uint64_t{1} << (31 + shift)) + f - 1) / f,
                   .shift = 31 + shift,
                   .limit = ((kRansLowerBound >> kRansProbabilityBits) << 8) * f,
                   .frequency = f,
                   .start = start};
    }
    start += f;
  }
}

void RansTable::encode(std::span<const std::uint8_t> symbols,
                       std::vector<std::uint8_t>& out) const {
  if (symbols.empty()) return;
  // A symbol of frequency 1 costs 14 bits: two bytes each are enough.
  const std::size_t before = out.size();
  const std::size_t room = 2 * symbols.size() + 4;
  out.resize(before + room);
  std::uint8_t* const begin = out.data() + before;
  std::uint8_t* at = begin + room;
  std::uint32_t state = kRansLowerBound;
  for (std::size_t i = symbols.size(); i-- > 0;) {
    const Step& step = steps_[symbols[i]];
    while (state >= step.limit) {
      *--at = static_cast<std::uint8_t>(state);
      state >>= 8;
    }
    const auto quotient = static_cast<std::uint32_t>(state * step.reciprocal >> step.shift);
    state = (quotient << kRansProbabilityBits) + (state - quotient * step.frequency) + step.start;
  }
  at -= 4;
  std::memcpy(at, &state, sizeof state);
  const auto size = static_cast<std::size_t>(begin + room - at);
  std::memmove(begin, at, size);
  out.resize(before + size);
}

}  // namespace cvr::codecs::entropy
