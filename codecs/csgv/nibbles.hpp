// Bricks of plain nibbles, 8 symbols a word, first in the low nibble: what `csgv-nibble` and
// `csgvr-nibble` store.
#pragma once

#include <cstdint>
#include <vector>

#include "codecs/codec.hpp"
#include "codecs/csgv/lanes.hpp"
#include "codecs/csgv/operations.hpp"

namespace cvr::codecs::csgv {

/// Appends whole bricks: level starts, palette size, symbols, palette; see OperationEncoder.
struct NibbleAppender {
  void operator()(const OperationStream& operations, std::vector<std::uint32_t>& words,
                  ByteBreakdown& bytes) const;
};

/// Hands out nibbles; a Reader for Reconstruction.
class NibbleReader {
 public:
  NibbleReader(const std::uint32_t* words, std::uint64_t word_count)
      : words_(words), end_(8 * word_count) {}
  void begin_level(unsigned, bool) {}
  bool take(unsigned count, std::uint64_t& codes) {
    if (position_ + count > end_) return false;
    const std::uint64_t word = position_ / 8;
    std::uint64_t nibbles = words_[word];
    if ((word + 1) * 8 < end_) nibbles |= std::uint64_t{words_[word + 1]} << 32;
    nibbles >>= 4 * (position_ % 8);
    codes = nibbles_to_bytes(static_cast<std::uint32_t>(nibbles));
    if (count < 8) codes &= (std::uint64_t{1} << (8 * count)) - 1;
    position_ += count;
    return true;
  }

 private:
  const std::uint32_t* words_;
  std::uint64_t end_;
  std::uint64_t position_ = 0;
};

}  // namespace cvr::codecs::csgv
