// Random access into one brick of CSGV-R, with and without stop bits (CSGV-R paper, Algorithms 1 to
// 3).
//
// A node is (n, level): its Morton code within its level, level 0 being the coarsest (one node).
// Its label is found by following operations from node to node (parent, neighbour) until a palette
// operation is met. In the wavelet matrix an operation is the number of zeros before the first one,
// so the walk that finds "palette advance" or "palette last" has computed the palette index on the
// way.
//
// Brick layout in 32-bit words (L levels):
//   [T_0 .. T_{L-1}][palette size][bits of W][Z_1[0..4]][W_1 .. W_4][flat rank of W][W]
//   with stop bits: [flat rank of S][S][64-bit words of S]      then the palette, reversed: entry k is the k-th word from the end
// CVR_HOLD_HEADERS: an opened brick holds level starts and wavelet offsets. Dear for one node,
// cheap for many.
#ifndef CVR_CSGVR_GLSL
#define CVR_CSGVR_GLSL

#include "shaders/shared/bit_vector.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/operations.glsl"
#include "shaders/shared/portable.glsl"

#define CVR_WAVELET_LEVELS 5u
#define CVR_MOST_LEVELS 7u  // bricks of 64^3

struct CsgvrBrick {
  uint levels;
  uint words;  // of the whole brick
  uint palette_size;
  uint z_at;  // word of Z_1[0]; W_1 follows Z_1[4]
#ifdef CVR_HOLD_HEADERS
  uint starts[CVR_MOST_LEVELS];      // T_0 ..
  uint wavelet[CVR_WAVELET_LEVELS];  // see cvr_csgvr_wavelet_step
#else
  uint starts_at;  // word of T_0
#endif
  BitVector w;  // wavelet matrix
  BitVector s;  // stop bits; s.bits_at = 0: there are none
};

// First stream index of a level.
CVR_FUNC uint cvr_csgvr_start(Words words, CsgvrBrick brick, uint level) {
#ifdef CVR_HOLD_HEADERS
  uint start = brick.starts[0];
  CVR_UNROLL for (uint l = 1u; l < CVR_MOST_LEVELS; ++l) start =
      l == level ? brick.starts[l] : start;
  return start;
#else
  return cvr_read(words, brick.starts_at + level);
#endif
}

// What leads from a zero at bit `at` of a wavelet level, with `ones` before it, to its bit in the
// next level: at - ones + step. For the last level, the ones before it.
CVR_FUNC uint cvr_csgvr_wavelet_step(Words words, CsgvrBrick brick, uint level) {
#ifdef CVR_HOLD_HEADERS
  uint step = brick.wavelet[0];
  CVR_UNROLL for (uint l = 1u; l < CVR_WAVELET_LEVELS; ++l) step =
      l == level ? brick.wavelet[l] : step;
  return step;
#else
  uint step = cvr_read(words, brick.z_at + level);
  if (level == CVR_WAVELET_LEVELS - 1u) return step;
  step += cvr_read(words, brick.z_at + CVR_WAVELET_LEVELS + level);
  return level == 0u ? step : step - cvr_read(words, brick.z_at + CVR_WAVELET_LEVELS + level - 1u);
#endif
}

// Reads the header of the brick whose `word_count` words begin at `words`.
CVR_FUNC CsgvrBrick cvr_csgvr_open(Words words, uint word_count, uint levels, bool stop_bits) {
  CsgvrBrick brick;
  brick.levels = levels;
  brick.words = word_count;
  brick.palette_size = cvr_read(words, levels);
  uint w_bits = cvr_read(words, levels + 1u);
  brick.z_at = levels + 2u;
  brick.w.rank_at = brick.z_at + 2u * CVR_WAVELET_LEVELS - 1u;
  brick.w.bits_at = brick.w.rank_at + 2u * (w_bits / CVR_RANK_BLOCK_BITS + 1u);
  brick.w.size = w_bits;
  brick.s.rank_at = 0u;
  brick.s.bits_at = 0u;
  brick.s.size = 0u;
  if (stop_bits) {
    uint s_words = cvr_read(words, word_count - brick.palette_size - 1u);
    brick.s.bits_at = word_count - brick.palette_size - 1u - 2u * s_words;
    brick.s.rank_at = brick.w.bits_at + 2u * ((w_bits + 63u) / 64u);
    brick.s.size = cvr_read(
        words, brick.z_at + CVR_WAVELET_LEVELS);  // W_1: every symbol has a bit in the first level
  }
#ifdef CVR_HOLD_HEADERS
  CVR_UNROLL for (uint l = 0u; l < CVR_MOST_LEVELS; ++l) brick.starts[l] =
      l < levels ? cvr_read(words, l) : 0u;
  uint start = 0u;
  CVR_UNROLL for (uint l = 0u; l < CVR_WAVELET_LEVELS - 1u; ++l) {
    uint next = cvr_read(words, brick.z_at + CVR_WAVELET_LEVELS + l);
    brick.wavelet[l] = cvr_read(words, brick.z_at + l) + next - start;
    start = next;
  }
  brick.wavelet[CVR_WAVELET_LEVELS - 1u] = cvr_read(words, brick.z_at + CVR_WAVELET_LEVELS - 1u);
#else
  brick.starts_at = 0u;
#endif
  return brick;
}

// Stream index of a node (Algorithm 1). Where an ancestor carries a stop bit, n and level become
// that ancestor.
CVR_FUNC uint cvr_csgvr_index(Words words, CsgvrBrick brick, CVR_INOUT(uint) n,
                              CVR_INOUT(uint) level) {
  uint offset =
      0u;  // nodes of the current level that earlier stop bits have removed before n's ancestor
  if (brick.s.bits_at != 0u) {
    uint start = 0u;
    for (uint l = 0u; l < level; ++l) {
      uint ancestor = n >> (3u * (level - l));
      uint at = start + ancestor - offset;
      uint word = cvr_bit_word(words, brick.s, at);
      if (((word >> (at & 31u)) & 1u) == 1u) {
        n = ancestor;
        level = l;
        return at;
      }
      // Ones before the level: all nodes before it but those that have the children up to its end.
      uint end = cvr_csgvr_start(words, brick, l + 1u);
      offset = 8u * (offset + cvr_rank1_in(words, brick.s, at, word) - (start - (end - 1u) / 8u));
      start = end;
    }
    return start + n - offset;
  }
  return cvr_csgvr_start(words, brick, level) + n;
}

// The operation at a stream index (Algorithm 2). For palette operations `advances` is the number of
// "advance" operations before the index (Algorithm 3); otherwise it is 0.
CVR_FUNC uint cvr_csgvr_operation(Words words, CsgvrBrick brick, uint i, CVR_OUT(uint) advances) {
  advances = 0u;
  for (uint l = 0u; l < CVR_WAVELET_LEVELS; ++l) {
    bool last = l == CVR_WAVELET_LEVELS - 1u;
    uint word = cvr_bit_word(words, brick.w, i);
    uint bit = (word >> (i & 31u)) & 1u;
    if (bit == 1u && !last) return l;
    uint ones = cvr_rank1_in(words, brick.w, i, word);
    uint step = cvr_csgvr_wavelet_step(words, brick, l);
    if (last) {
      advances = ones - step;
      return bit == 1u ? CVR_OP_ADVANCE : CVR_OP_LAST;
    }
    i = i - ones + step;
  }
  return CVR_OP_LAST;
}

// Palette index of a node's label. `hops` counts the operations read. False on a chain that no
// encoder writes.
CVR_FUNC bool cvr_csgvr_palette_index(Words words, CsgvrBrick brick, uint n, uint level,
                                      CVR_OUT(uint) index, CVR_INOUT(uint) hops) {
  index = 0u;
  while (true) {
    uint i = cvr_csgvr_index(words, brick, n, level);
    uint advances;
    uint operation = cvr_csgvr_operation(words, brick, i, advances);
    hops += 1u;
    if (operation >= CVR_OP_ADVANCE) {
      index = operation == CVR_OP_ADVANCE ? advances : advances - 1u;
      return index < brick.palette_size;
    }
    if (!cvr_csgvr_follow(operation, n, level)) return false;
  }
  return false;
}

// The label at a palette index below brick.palette_size. The palette is never copied to shared
// memory.
CVR_FUNC uint cvr_csgvr_label(Global words, CsgvrBrick brick, uint index) {
  return cvr_read_global(words, brick.words - 1u - index);
}

#endif
