// Bit vectors with constant-time rank (supplemental of the CSGV-R paper, section 1 and Algorithm
// S1; flat rank after Kurpicz 2022 with one level less).
//
// A bit vector is an array of 64-bit words, first bit in the least significant place. Its flat rank
// has one 64-bit entry per 1280 bits, and one for the end: bits 0..19 L1 = ones before the block,
// then four 11-bit counts L2 = ones of the block before its 256-bit sub-blocks 1 to 4. floor(size /
// 1280) + 1 entries, so that rank(size) is legal. Both arrays begin at any 32-bit word.
#ifndef CVR_BIT_VECTOR_GLSL
#define CVR_BIT_VECTOR_GLSL

#include "shaders/shared/portable.glsl"

#define CVR_RANK_BLOCK_BITS 1280u
#define CVR_RANK_SUB_BLOCK_BITS 256u

struct BitVector {
  uint bits_at;  // 32-bit word at which the bits begin
  uint rank_at;  // 32-bit word at which the flat rank begins
  uint size;     // bits
};

// The 32-bit word that holds bit i, which is its bit i & 31.
CVR_FUNC uint cvr_bit_word(Words words, BitVector v, uint i) {
  return cvr_read(words, v.bits_at + (i >> 5));
}

CVR_FUNC uint cvr_bit(Words words, BitVector v, uint i) {
  return (cvr_bit_word(words, v, i) >> (i & 31u)) & 1u;
}

// Ones before bit i, whose word has been read: from the nearer end of its sub-block, or from the
// begin where the end has no entry.
CVR_FUNC uint cvr_rank1_in(Words words, BitVector v, uint i, uint word) {
  uint sub_block = i >> 8;
  uint before = (i >> 5) & 7u;  // words of the sub-block before i's
  bool down = before >= 4u && (sub_block + 1u) * CVR_RANK_SUB_BLOCK_BITS <= v.size;
  uint from = sub_block + (down ? 1u : 0u);
  uint block = from / 5u;
  uint part = from - 5u * block;
  uint64_t entry = cvr_word64(words, v.rank_at + 2u * block);
  uint count = uint(entry) & 0xfffffu;
  if (part > 0u) count += uint(entry >> (9u + 11u * part)) & 0x7ffu;
  uint at = v.bits_at + (i >> 5);
  uint others = down ? 7u - before : before;
  uint step = down ? 1u : ~0u;
  uint ones = cvr_popcount32(down ? word >> (i & 31u) : word & ((1u << (i & 31u)) - 1u));
  CVR_UNROLL for (uint k = 0u; k < 3u; ++k) {
    if (k >= others) break;
    at += step;
    ones += cvr_popcount32(cvr_read(words, at));
  }
  for (uint k = 3u; k < others; ++k) {
    at += step;
    ones += cvr_popcount32(cvr_read(words, at));
  }
  return down ? count - ones : count + ones;
}

// Ones before bit i; i may be the size.
CVR_FUNC uint cvr_rank1(Words words, BitVector v, uint i) {
  return cvr_rank1_in(words, v, i, i < v.size || (i & 31u) != 0u ? cvr_bit_word(words, v, i) : 0u);
}

#endif
