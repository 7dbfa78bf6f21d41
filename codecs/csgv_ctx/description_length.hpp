// Description lengths as integers, so that every build decides alike.
#pragma once

#include <array>
#include <cstdint>

namespace cvr::codecs::csgv_ctx {

/// In units of 2^-12 bits.
using Cost = std::int64_t;
inline constexpr unsigned kCostBits = 12;
constexpr Cost bits(Cost count) { return count << kCostBits; }

/// Counts of the first N symbols: the finest level has but eight.
template <std::size_t N>
using Counts = std::array<std::uint32_t, N>;

/// log2(n), n >= 1; above 2^12 interpolated.
Cost log2_of(std::uint64_t n);

inline Cost n_log_n(std::uint64_t n) { return n == 0 ? 0 : static_cast<Cost>(n) * log2_of(n); }

}  // namespace cvr::codecs::csgv_ctx
