// Packing symbols into nibbles, eight at once.
#include "codecs/csgv/nibbles.hpp"

#include <cstring>

#include "codecs/csgv/operation_encoder.hpp"

namespace cvr::codecs::csgv {

namespace {

/// 8 a word, first in the low nibble.
void append_nibbles(std::span<const std::uint8_t> symbols, std::vector<std::uint32_t>& words) {
  const std::size_t at = words.size();
  words.resize(at + (symbols.size() + 7) / 8);
  const auto pack8 = [](std::uint64_t bytes) {
    bytes = (bytes | bytes >> 4) & 0x00ff00ff00ff00ffu;
    bytes = (bytes | bytes >> 8) & 0x0000ffff0000ffffu;
    return static_cast<std::uint32_t>(bytes | bytes >> 16);
  };
  std::size_t i = 0;
  for (; i + 8 <= symbols.size(); i += 8) {
    std::uint64_t bytes;
    std::memcpy(&bytes, symbols.data() + i, sizeof bytes);
    words[at + i / 8] = pack8(bytes);
  }
  if (i < symbols.size()) {
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, symbols.data() + i, symbols.size() - i);
    words[at + i / 8] = pack8(bytes);
  }
}

}  // namespace

void NibbleAppender::operator()(const OperationStream& operations,
                                std::vector<std::uint32_t>& words, ByteBreakdown& bytes) const {
  append_level_starts(operations, words);
  const std::size_t operations_at = words.size();
  append_nibbles(operations.symbols(), words);
  bytes[ByteClass::kHeader] += 4 * (operations.levels() + 1);
  bytes[ByteClass::kOperations] += 4 * (words.size() - operations_at);
  append_palette(operations, words);
  bytes[ByteClass::kPalette] += 4 * operations.palette().size();
}

}  // namespace cvr::codecs::csgv
