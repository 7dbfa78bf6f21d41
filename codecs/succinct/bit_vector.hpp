// Building and checking the bit vectors that shaders/shared/bit_vector.glsl reads: 64-bit words,
// flat rank of 1280-bit blocks.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#if defined(__BMI2__) && !defined(CVR_SCALAR)
#include <immintrin.h>
#endif

namespace cvr::codecs::succinct {

struct FlatRankLayout {
  static constexpr std::uint32_t kBlockBits = 1280;     ///< one entry each
  static constexpr std::uint32_t kSubBlockBits = 256;   ///< five a block
  static constexpr std::uint32_t kFirstCountBits = 20;  ///< ones before the block
  static constexpr std::uint32_t kCountBits = 11;  ///< ones of the block before sub-blocks 1..4
};

/// Entries of a flat rank over `bits` bits: rank(bits) is legal.
constexpr std::uint32_t flat_rank_entries(std::uint32_t bits) {
  return bits / FlatRankLayout::kBlockBits + 1;
}
constexpr std::uint32_t words64(std::uint32_t bits) { return (bits + 63) / 64; }

/// The bits of `value` at the set bits of `mask`, moved together.
inline std::uint64_t extract_bits(std::uint64_t value, std::uint64_t mask) {
#if defined(__BMI2__) && !defined(CVR_SCALAR)
  return _pext_u64(value, mask);
#else
  std::uint64_t result = 0;
  for (unsigned i = 0; mask != 0; mask &= mask - 1, ++i)
    result |= (value >> std::countr_zero(mask) & 1) << i;
  return result;
#endif
}

/// The low bits of `value` moved to the set bits of `mask`.
inline std::uint64_t deposit_bits(std::uint64_t value, std::uint64_t mask) {
#if defined(__BMI2__) && !defined(CVR_SCALAR)
  return _pdep_u64(value, mask);
#else
  std::uint64_t result = 0;
  for (; mask != 0; mask &= mask - 1, value >>= 1) result |= (value & 1) << std::countr_zero(mask);
  return result;
#endif
}

/// A bit vector under construction. Reused: clear() keeps the memory.
class BitAppender {
 public:
  void clear() {
    size_ = 0;
    words_.clear();
  }
  std::uint32_t size() const { return size_; }
  /// words64(size()) words; bits beyond the size are zero.
  std::span<const std::uint64_t> words() const { return words_; }
  /// Appends the low `count` <= 64 bits; higher bits of `bits` must be zero.
  void append(std::uint64_t bits, unsigned count) {
    if (count == 0) return;
    const unsigned at = size_ % 64;
    if (at == 0) {
      words_.push_back(bits);
    } else {
      words_.back() |= bits << at;
      if (at + count > 64) words_.push_back(bits >> (64 - at));
    }
    size_ += count;
  }
  void append(const BitAppender& other) {
    std::uint32_t left = other.size();
    for (const std::uint64_t word : other.words()) {
      append(word, left < 64 ? left : 64);
      left -= left < 64 ? left : 64;
    }
  }

 private:
  std::vector<std::uint64_t> words_;
  std::uint32_t size_ = 0;
};

/// Appends the flat rank of a bit vector, as 32-bit words.
void append_flat_rank(std::span<const std::uint64_t> words, std::uint32_t bits,
                      std::vector<std::uint32_t>& out);

/// Appends the bits as 32-bit words, two for each 64-bit word.
void append_words(std::span<const std::uint64_t> words, std::vector<std::uint32_t>& out);

/// Whether `rank` (2 x flat_rank_entries(bits) words) is the flat rank of the bits at `words` (2 x
/// words64(bits) words).
bool check_flat_rank(const std::uint32_t* words, std::uint32_t bits, const std::uint32_t* rank);

}  // namespace cvr::codecs::succinct
