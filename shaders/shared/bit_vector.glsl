// Bit vectors with constant-time rank (supplemental of the CSGV-R paper, section 1 and Algorithm S1; flat rank after Kurpicz
// 2022 with one level less).
//
// A bit vector is an array of 64-bit words, first bit in the least significant place. Its flat rank has one 64-bit entry per
// 1280 bits, and one for the end: bits 0..19 L1 = ones before the block, then four 11-bit counts L2 = ones of the block
// before its 256-bit sub-blocks 1 to 4. floor(size / 1280) + 1 entries, so that rank(size) is legal.
// Both arrays begin at any 32-bit word.
#ifndef CVR_BIT_VECTOR_GLSL
#define CVR_BIT_VECTOR_GLSL

#define CVR_RANK_BLOCK_BITS 1280u
#define CVR_RANK_SUB_BLOCK_BITS 256u

struct BitVector {
  uint bits_at;  // 32-bit word at which the bits begin
  uint rank_at;  // 32-bit word at which the flat rank begins
};

CVR_FUNC uint cvr_bit(Words words, BitVector v, uint i) { return (cvr_read(words, v.bits_at + (i >> 5)) >> (i & 31u)) & 1u; }

// Ones before bit i; i may be the size.
CVR_FUNC uint cvr_rank1(Words words, BitVector v, uint i) {
  uint block = i / CVR_RANK_BLOCK_BITS;
  uint64_t entry = cvr_word64(words, v.rank_at + 2u * block);
  uint sub_block = (i - block * CVR_RANK_BLOCK_BITS) / CVR_RANK_SUB_BLOCK_BITS;
  uint count = uint(entry) & 0xfffffu;
  if (sub_block > 0u) count += uint(entry >> (9u + 11u * sub_block)) & 0x7ffu;
  uint at = v.bits_at + 2u * (block * 20u + sub_block * 4u);
  uint rest = i - block * CVR_RANK_BLOCK_BITS - sub_block * CVR_RANK_SUB_BLOCK_BITS;
  CVR_UNROLL for (uint k = 0u; k < 3u; ++k) {
    if (rest < 64u) break;
    count += cvr_popcount(cvr_word64(words, at));
    at += 2u;
    rest -= 64u;
  }
  if (rest > 0u) count += cvr_popcount(cvr_word64(words, at) << (64u - rest));
  return count;
}

#endif
