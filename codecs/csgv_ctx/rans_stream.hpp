// Range asymmetric numeral systems for very short streams (Duda 2013): one stream a brick.
//
// State of 32 bits, renormalised by words of 16 bits at 2^16, probabilities in units of 2^-12. What
// is unusual: the encoder begins with the state 0, so that nothing is spent on a first state, and
// stores no more bytes of its last one than it has. The decoder ends with 0, which is checked: a
// damaged stream ends with it by chance alone.
//
// Bytes: the last state, little endian, its leading zero bytes left out; then the words. A stream
// with words has three or four bytes of state, which the parity of its length tells.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "codecs/csgv/lanes.hpp"

namespace cvr::codecs::csgv_ctx {

inline constexpr unsigned kProbabilityBits = 12;
inline constexpr std::uint32_t kProbabilitySum = 1u << kProbabilityBits;
inline constexpr unsigned kSymbols = 16;

/// Frequencies of 16 symbols that sum to 2^12, and where the slots of each begin.
struct alignas(64) Distribution {
  std::array<std::uint16_t, kSymbols> start{};
  std::array<std::uint16_t, kSymbols> frequency{};

  static Distribution of(const std::array<std::uint16_t, kSymbols>& frequencies) {
    Distribution distribution;
    distribution.frequency = frequencies;
    std::uint32_t sum = 0;
    for (unsigned s = 0; s < kSymbols; ++s) {
      distribution.start[s] = static_cast<std::uint16_t>(sum);
      sum += frequencies[s];
    }
    return distribution;
  }

  /// The symbol that owns a slot: the last one that begins at or before it.
  unsigned symbol(std::uint32_t slot) const {
#ifdef CVR_LANES_AVX2
    const __m256i begins = _mm256_load_si256(reinterpret_cast<const __m256i*>(start.data()));
    const __m256i beyond = _mm256_cmpgt_epi16(begins, _mm256_set1_epi16(static_cast<short>(slot)));
    return static_cast<unsigned>(
               std::countr_zero(static_cast<std::uint64_t>(
                                    static_cast<std::uint32_t>(_mm256_movemask_epi8(beyond))) |
                                std::uint64_t{1} << 32)) /
               2 -
           1;
#else
    unsigned count = 0;
    for (unsigned s = 1; s < kSymbols; ++s) count += start[s] <= slot ? 1u : 0u;
    return count;
#endif
  }
};

/// ceil(2^44 / f): of every x below 2^32, floor(x / f) is floor(x * kReciprocals[f] / 2^44), as x *
/// (f - 1) is below 2^44.
inline constexpr auto kReciprocals = [] {
  std::array<std::uint64_t, kProbabilitySum + 1> table{};
  for (std::uint64_t f = 1; f <= kProbabilitySum; ++f)
    table[f] = ((std::uint64_t{1} << 44) + f - 1) / f;
  return table;
}();

/// Writes one stream: what is put first is decoded last.
class StreamEncoder {
 public:
  /// Of at most so many symbols and pieces of numbers; `words` is scratch memory.
  StreamEncoder(std::vector<std::uint16_t>& words, std::size_t symbols) {
    if (words.size() < symbols) words.resize(symbols);
    end_ = at_ = words.data() + words.size();
  }
  /// The slots [start, start + frequency), frequency > 0.
  void put(std::uint32_t start, std::uint32_t frequency) {
    if (state_ >= std::uint64_t{frequency} << (32 - kProbabilityBits)) {
      *--at_ = static_cast<std::uint16_t>(state_);
      state_ >>= 16;
    }
    const auto quotient = static_cast<std::uint32_t>(
        static_cast<unsigned __int128>(std::uint64_t{state_} << 20) * kReciprocals[frequency] >>
        64);
    state_ += quotient * (kProbabilitySum - frequency) + start;
  }
  void put(const Distribution& distribution, unsigned symbol) {
    put(distribution.start[symbol], distribution.frequency[symbol]);
  }
  /// The low `count` <= 12 bits of a number, all equally likely.
  void put_bits(std::uint32_t value, unsigned count) {
    put(value << (kProbabilityBits - count), kProbabilitySum >> count);
  }

  /// Appends the stream to `out`.
  void finish(std::vector<std::uint8_t>& out) const {
    const unsigned least = at_ == end_ ? 0 : 3;
    for (unsigned i = 0; i < 4 && (state_ >> (8 * i) != 0 || i < least); ++i)
      out.push_back(static_cast<std::uint8_t>(state_ >> (8 * i)));
    const auto words = std::as_bytes(std::span(at_, end_));
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(words.data());
    out.insert(out.end(), bytes, bytes + words.size());
  }

 private:
  std::uint16_t* end_;
  std::uint16_t* at_;  ///< words lie as the decoder reads them
  std::uint32_t state_ = 0;
};

/// Reads one stream forwards; where its words end, zeros of the state go on.
class StreamDecoder {
 public:
  explicit StreamDecoder(std::span<const std::uint8_t> bytes)
      : at_(bytes.data()), end_(bytes.data() + bytes.size()) {
    const std::size_t length = bytes.size() < 4 ? bytes.size() : 4 - bytes.size() % 2;
    for (std::size_t i = 0; i < length; ++i) state_ |= std::uint32_t{*at_++} << (8 * i);
  }

  unsigned next(const Distribution& distribution) {
    const std::uint32_t slot = state_ & (kProbabilitySum - 1);
    const unsigned symbol = distribution.symbol(slot);
    advance(distribution.frequency[symbol], slot - distribution.start[symbol]);
    return symbol;
  }
  /// `count` <= 12 equally likely bits.
  std::uint32_t bits(unsigned count) {
    const std::uint32_t slot = state_ & (kProbabilitySum - 1);
    const unsigned rest = kProbabilityBits - count;
    advance(1u << rest, slot & ((1u << rest) - 1));
    return slot >> rest;
  }
  /// Whether everything that was encoded has been read, and nothing else.
  bool at_end() const { return state_ == 0 && at_ == end_; }

 private:
  void advance(std::uint32_t frequency, std::uint32_t place) {
    state_ = frequency * (state_ >> kProbabilityBits) + place;
    if (state_ < 1u << 16 && at_ != end_) {
      std::uint16_t word;
      std::memcpy(&word, at_, sizeof word);
      state_ = state_ << 16 | word;
      at_ += 2;
    }
  }

  const std::uint8_t* at_;
  const std::uint8_t* end_;
  std::uint32_t state_ = 0;
};

}  // namespace cvr::codecs::csgv_ctx
