#include "codecs/entropy/prefix_code.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>

namespace cvr::codecs::entropy {

namespace {

constexpr unsigned kMostBits = 31;

/// A symbol, or two things of the list before.
struct Package {
  std::uint64_t weight;
  std::int32_t first, second;  ///< places in the pool; a symbol: the symbol and -1
};

std::uint32_t reversed(std::uint32_t code, unsigned length) {
  std::uint32_t bits = 0;
  for (unsigned i = 0; i < length; ++i) bits |= (code >> i & 1) << (length - 1 - i);
  return bits;
}

}  // namespace

std::vector<std::uint8_t> prefix_code_lengths(std::span<const std::uint64_t> counts, unsigned limit) {
  std::vector<std::uint32_t> order(counts.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t s) { return counts[s]; });

  std::vector<Package> pool;
  std::vector<std::int32_t> symbols;
  for (const std::uint32_t s : order) {
    symbols.push_back(static_cast<std::int32_t>(pool.size()));
    pool.push_back({counts[s], static_cast<std::int32_t>(s), -1});
  }
  const auto lighter = [&](std::int32_t a, std::int32_t b) { return pool[a].weight < pool[b].weight; };
  std::vector<std::int32_t> list = symbols;
  for (unsigned level = 1; level < limit; ++level) {
    std::vector<std::int32_t> packages;
    for (std::size_t i = 0; i + 1 < list.size(); i += 2) {
      packages.push_back(static_cast<std::int32_t>(pool.size()));
      pool.push_back({pool[list[i]].weight + pool[list[i + 1]].weight, list[i], list[i + 1]});
    }
    list.clear();
    std::ranges::merge(symbols, packages, std::back_inserter(list), lighter);
  }
  // A symbol's length is how often it occurs in the lightest 2n - 2 things.
  std::vector<std::uint8_t> lengths(counts.size());
  std::vector<std::int32_t> open(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(2 * counts.size() - 2));
  while (!open.empty()) {
    const Package package = pool[open.back()];
    open.pop_back();
    if (package.second < 0) {
      ++lengths[package.first];
    } else {
      open.push_back(package.first);
      open.push_back(package.second);
    }
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
