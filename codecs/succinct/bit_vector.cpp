#include "codecs/succinct/bit_vector.hpp"

#include <cstring>

namespace cvr::codecs::succinct {

namespace {

/// Calls entry(block, value) for every flat-rank entry; word(i) gives the i-th 64-bit word.
template <class Word, class Entry>
void for_each_entry(std::uint32_t bits, Word&& word, Entry&& entry) {
  constexpr std::uint32_t kWords = FlatRankLayout::kBlockBits / 64;
  const std::uint32_t count = words64(bits);
  std::uint64_t ones = 0;
  for (std::uint32_t block = 0; block < flat_rank_entries(bits); ++block) {
    std::uint64_t value = ones;
    std::uint64_t in_block = 0;
    for (std::uint32_t i = 0; i < kWords; ++i) {
      if (i > 0 && i % 4 == 0)
        value |= in_block << (FlatRankLayout::kFirstCountBits +
                              FlatRankLayout::kCountBits * (i / 4 - 1));
      const std::uint32_t at = block * kWords + i;
      if (at < count) in_block += static_cast<std::uint64_t>(std::popcount(word(at)));
    }
    entry(block, value);
    ones += in_block;
  }
}

std::uint64_t load64(const std::uint32_t* words, std::uint32_t i) {
  std::uint64_t value;
  std::memcpy(&value, words + 2 * i, sizeof value);
  return value;
}

}  // namespace

void append_flat_rank(std::span<const std::uint64_t> words, std::uint32_t bits,
                      std::vector<std::uint32_t>& out) {
  for_each_entry(
      bits, [&](std::uint32_t i) { return words[i]; },
      [&](std::uint32_t, std::uint64_t value) {
        out.push_back(static_cast<std::uint32_t>(value));
        out.push_back(static_cast<std::uint32_t>(value >> 32));
      });
}

void append_words(std::span<const std::uint64_t> words, std::vector<std::uint32_t>& out) {
  const std::size_t at = out.size();
  out.resize(at + 2 * words.size());
  if (!words.empty()) std::memcpy(out.data() + at, words.data(), words.size_bytes());
}

bool check_flat_rank(const std::uint32_t* words, std::uint32_t bits, const std::uint32_t* rank) {
  bool equal = true;
  for_each_entry(
      bits, [&](std::uint32_t i) { return load64(words, i); },
      [&](std::uint32_t block, std::uint64_t value) { equal &= load64(rank, block) == value; });
  // Bits beyond the size would be counted by the entries but not by any query.
  return equal && (bits % 64 == 0 || load64(words, bits / 64) >> (bits % 64) == 0);
}

}  // namespace cvr::codecs::succinct
