// Canonical prefix codes of limited length: optimal lengths by package-merge (Larmore, Hirschberg
// 1990), bits in the order in which they are read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cvr::codecs::entropy {

/// Code lengths, 1..limit, that minimise the sum of count * length. At least 2 and at most 2^limit
/// counts, each at least 1.
std::vector<std::uint8_t> prefix_code_lengths(std::span<const std::uint64_t> counts,
                                              unsigned limit);

/// The codes of these lengths, first bit lowest: shorter ones first, equal lengths in the order of
/// the symbols.
std::vector<std::uint32_t> prefix_codes(std::span<const std::uint8_t> lengths);

/// Whether lengths of at least 1 use up all codes: sum of 2^-length = 1.
bool is_complete_prefix_code(std::span<const std::uint8_t> lengths);

}  // namespace cvr::codecs::entropy
