// Bit fields in words of 32 bits, first bit in the least significant place.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cvr::codecs {

/// Appends bit fields to `words`, beginning with a new word.
class BitWriter {
 public:
  explicit BitWriter(std::vector<std::uint32_t>& words) : words_(words) {}
  /// The low `count` <= 32 bits of `value`; higher ones must be zero.
  void put(std::uint32_t value, unsigned count) {
    if (count == 0) return;
    const unsigned at = bits_ % 32;
    if (at == 0) words_.push_back(0);
    words_.back() |= value << at;
    if (at + count > 32) words_.push_back(value >> (32 - at));
    bits_ += count;
  }
  std::uint64_t bits() const { return bits_; }

 private:
  std::vector<std::uint32_t>& words_;
  std::uint64_t bits_ = 0;
};

/// Reads them back. After an attempt to read past the end every field is zero and failed() is true.
class BitReader {
 public:
  explicit BitReader(std::span<const std::uint32_t> words, std::uint64_t position = 0)
      : words_(words.data()),
        end_(32 * static_cast<std::uint64_t>(words.size())),
        position_(position) {}
  std::uint32_t get(unsigned count) {
    if (count == 0) return 0;
    if (count > end_ - position_ || failed_) {
      failed_ = true;
      return 0;
    }
    const std::uint64_t word = position_ / 32;
    std::uint64_t both = words_[word];
    if (position_ % 32 + count > 32) both |= std::uint64_t{words_[word + 1]} << 32;
    const auto value =
        static_cast<std::uint32_t>(both >> (position_ % 32)) & (~std::uint32_t{0} >> (32 - count));
    position_ += count;
    return value;
  }
  std::uint64_t position() const { return position_; }
  bool failed() const { return failed_; }

 private:
  const std::uint32_t* words_;
  std::uint64_t end_;
  std::uint64_t position_;
  bool failed_ = false;
};

}  // namespace cvr::codecs
