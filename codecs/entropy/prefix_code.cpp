#include "codecs/entropy/prefix_code.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace cvr::codecs::entropy {

namespace {

constexpr unsigned kMostBits = 31;

std::uint32_t reversed(std::uint32_t code, unsigned length) {
  std::uint32_t bits = 0;
  for (unsigned i = 0; i < length; ++i) bits |= (code >> i & 1) << (length - 1 - i);
  return bits;
}

}  // namespace

std::vector<std::uint8_t> prefix_code_lengths(std::span<const std::uint64_t> counts,
                                              unsigned limit) {
  std::vector<std::uint32_t> order(counts.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t s) { return counts[s]; });

  // Lists of things, lightest first: symbols, and from the second list on packages of two things of
  // the list before.
  std::vector<std::uint64_t> symbols;
  for (const std::uint32_t s : order) symbols.push_back(counts[s]);
  std::vector<std::vector<std::uint8_t>> is_symbol{std::vector<std::uint8_t>(symbols.size(), 1)};
  std::vector<std::uint64_t> list = symbols;
  for (unsigned level = 1; level < limit; ++level) {
    std::vector<std::uint64_t> packages;
    for (std::size_t i = 0; i + 1 < list.size(); i += 2) packages.push_back(list[i] + list[i + 1]);
    list.clear();
    std::vector<std::uint8_t>& kinds = is_symbol.emplace_back();
    for (std::size_t s = 0, p = 0; s < symbols.size() || p < packages.size();) {
      const bool symbol = p == packages.size() || (s < symbols.size() && symbols[s] <= packages[p]);
      list.push_back(symbol ? symbols[s++] : packages[p++]);
      kinds.push_back(symbol ? 1 : 0);
    }
  }
  // A symbol's length is how often it occurs in the lightest 2n - 2 things of the last list: those
  // of a list that are symbols are the lightest ones, those that are packages are made of the
  // lightest things of the list before.
  std::vector<std::uint8_t> lengths(counts.size());
  std::size_t taken = 2 * counts.size() - 2;
  for (std::size_t level = is_symbol.size(); level-- > 0;) {
    const auto first = is_symbol[level].begin();
    const auto of_symbols = static_cast<std::size_t>(
        std::accumulate(first, first + static_cast<std::ptrdiff_t>(taken), 0u));
    for (std::size_t i = 0; i < of_symbols; ++i) ++lengths[order[i]];
    taken = 2 * (taken - of_symbols);
  }
  return lengths;
}

std::vector<std::uint32_t> prefix_codes(std::span<const std::uint8_t> lengths) {
  std::array<std::uint32_t, kMostBits + 1> of_length{}, next{};
  for (const std::uint8_t length : lengths) ++of_length[length];
  for (unsigned l = 1; l <= kMostBits; ++l) next[l] = (next[l - 1] + of_length[l - 1]) << 1;
  std::vector<std::uint32_t> codes;
  codes.reserve(lengths.size());
  for (const std::uint8_t length : lengths) codes.push_back(reversed(next[length]++, length));
  return codes;
}

bool is_complete_prefix_code(std::span<const std::uint8_t> lengths) {
  std::uint64_t used = 0;
  for (const std::uint8_t length : lengths) used += std::uint64_t{1} << (kMostBits - length);
  return used == std::uint64_t{1} << kMostBits;
}

}  // namespace cvr::codecs::entropy
