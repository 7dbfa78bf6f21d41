#include "codecs/csgv_ctx/description_length.hpp"

#include <bit>

namespace cvr::codecs::csgv_ctx {

namespace {

/// log2 of 1..2^12 in units of 2^-12, by repeated squaring.
const std::array<std::uint16_t, 4097>& log_table() {
  static const auto kTable = [] {
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
  return kTable;
}

}  // namespace

Cost log2_of(std::uint64_t n) {
  static const auto& table = log_table();
  if (n <= 4096) return table[n];
  const auto shift = static_cast<unsigned>(std::bit_width(n)) - 12;
  const std::uint64_t high = n >> shift;
  const Cost step = table[high + 1] - table[high];
  return bits(shift) + table[high] + (step * static_cast<Cost>((n >> (shift - 1)) & 1) >> 1);
}

}  // namespace cvr::codecs::csgv_ctx
