// Random access into one brick of CSGV-R Nibble (supplemental, section 3): every node has a plain
// 4-bit operation and there is no rank structure, so the palette index is counted by a loop over
// all earlier operations. It shows what the wavelet matrix brings.
//
// Brick layout in 32-bit words (L levels):
//   [T_0 .. T_{L-1}][palette size][operations, 8 a word, first in the low nibble][palette,
//   reversed]
#ifndef CVR_CSGVR_NIBBLE_GLSL
#define CVR_CSGVR_NIBBLE_GLSL

#include "shaders/shared/operations.glsl"
#include "shaders/shared/portable.glsl"

CVR_FUNC uint cvr_nibble(Words words, uint first_word, uint i) {
  return (cvr_read(words, first_word + (i >> 3)) >> (4u * (i & 7u))) & 15u;
}

#define CVR_NIBBLE_WORDS 16u  // counted in one iteration

// "Advance" operations among the nibbles [0, i).
CVR_FUNC uint cvr_nibble_advances(Words words, uint first_word, uint i) {
  uint count = 0u;
  for (uint group = 0u; group < i; group += 8u * CVR_NIBBLE_WORDS) {
    CVR_UNROLL for (uint k = 0u; k < CVR_NIBBLE_WORDS; ++k) {
      uint before = group + 8u * k;
      if (before >= i) break;
      uint left = i - before;
      uint x = cvr_read(words, first_word + (before >> 3)) ^
               0x44444444u;  // a nibble is zero where the operation is "advance"
      uint non_zero = (x | (x >> 1) | (x >> 2) | (x >> 3)) & 0x11111111u;
      uint advances = non_zero ^ 0x11111111u;
      if (left < 8u) advances &= (1u << (4u * left)) - 1u;
      count += cvr_popcount(uint64_t(advances));
    }
  }
  return count;
}

// Palette index of a node's label; false on a chain that no encoder writes.
CVR_FUNC bool cvr_csgvr_nibble_palette_index(Words words, uint levels, uint n, uint level,
                                             CVR_OUT(uint) index, CVR_INOUT(uint) hops) {
  uint first_word = levels + 1u;
  index = 0u;
  while (true) {
    uint i = cvr_read(words, level) + n;
    uint operation = cvr_nibble(words, first_word, i);
    hops += 1u;
    if (operation > CVR_OP_LAST) return false;
    if (operation >= CVR_OP_ADVANCE) {
      uint advances = cvr_nibble_advances(words, first_word, i);
      index = operation == CVR_OP_ADVANCE ? advances : advances - 1u;
      return index < cvr_read(words, levels);
    }
    if (!cvr_csgvr_follow(operation, n, level)) return false;
  }
  return false;
}

#endif
