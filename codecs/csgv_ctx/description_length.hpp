// Description lengths as integers, so that every build decides alike.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace cvr::codecs::csgv_ctx {

/// In units of 2^-12 bits.
using Cost = std::int64_t;
inline constexpr unsigned kCostBits = 12;
constexpr Cost bits(Cost count) { return count << kCostBits; }

/// Counts of the first N symbols: the finest level has but eight.
template <std::size_t N>
using Counts = std::array<std::uint32_t, N>;

/// log2 of 1..2^12 in units of 2^-12, by repeated squaring.
inline constexpr auto kLog2 = [] {
  std::array<std::uint16_t, 4097> table{};
  for (std::uint32_t n = 1; n <= 4096; ++n) {
    const auto whole = static_cast<unsigned>(std::bit_width(n)) - 1;
    std::uint64_t x = (std::uint64_t{n} << 31) >> whole;  // in [1, 2), 31 bits below the point
    std::uint32_t fraction = 0;
    for (unsigned i = 0; i < kCostBits; ++i) {
      x = x * x >> 31;
      fraction <<= 1;
      if (x >> 32 != 0) {
        fraction |= 1;
        x >>= 1;
      }
    }
    table[n] = static_cast<std::uint16_t>(whole << kCostBits | fraction);
  }
  return table;
}();

/// log2(n), n >= 1; above 2^12 interpolated.
inline Cost log2_of(std::uint64_t n) {
  if (n <= 4096) return kLog2[n];
  const auto shift = static_cast<unsigned>(std::bit_width(n)) - 12;
  const std::uint64_t high = n >> shift;
  const Cost step = kLog2[high + 1] - kLog2[high];
  return bits(shift) + kLog2[high] + (step * static_cast<Cost>((n >> (shift - 1)) & 1) >> 1);
}

inline Cost n_log_n(std::uint64_t n) { return n == 0 ? 0 : static_cast<Cost>(n) * log2_of(n); }

}  // namespace cvr::codecs::csgv_ctx
