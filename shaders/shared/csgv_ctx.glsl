// A group of bricks of `csgv-ctx`: where each brick's palette and stream lie (codecs/csgv_ctx/FORMAT.md, "Groups").
//
// Bit fields from the group's first word on, first bit in the least significant place:
//   [18: labels - 1][5: s, bits of a size][5: c, bits of a count]
//   [a bit for each brick: 1 = it has more than one label][a bit for each brick but the first: 1 = its root is not that of the brick before]
//   [r bits for each such root, and the first][label_bits for each label of the group]
//   [s + c bits for each brick with several labels: bytes of its stream, labels - 2][r bits for each further palette entry]
// then, from the next byte on, the streams, and zeros to a word.
// r: bits that number the labels of the group; a root or an entry is the place of a label in the group's list.
#ifndef CVR_CSGV_CTX_GLSL
#define CVR_CSGV_CTX_GLSL

#define CVR_CTX_LABELS_BITS 18u
#define CVR_CTX_SIZE_BITS 5u
#define CVR_CTX_HEADER_BITS 28u

struct CtxGroup {
  uint bricks;
  uint labels;      // of the list
  uint rank_bits;   // r
  uint size_bits;   // s
  uint count_bits;  // c
  uint several_at;  // bit at which the first bit for each brick lies; the others are bit positions too
  uint turns_at;
  uint roots_at;
  uint list_at;
  uint records_at;
};

struct CtxBrick {
  uint root;        // place in the group's list
  uint labels;      // palette entries; 1: the brick is constant and has no stream
  uint entries_at;  // bit at which its further entries begin
  uint stream_at;   // byte at which its stream begins
  uint bytes;       // of its stream
};

// Bits that number `count` >= 1 things.
CVR_FUNC uint cvr_ctx_bits_for(uint count) {
  uint bits = 0u;
  CVR_UNROLL for (uint i = 0u; i < 32u; ++i) bits += (count - 1u) >> i != 0u ? 1u : 0u;
  return bits;
}

// The field of `count` <= 32 bits at bit `at`.
CVR_FUNC uint cvr_ctx_field(Words words, uint at, uint count) {
  if (count == 0u) return 0u;
  uint shift = at & 31u;
  uint value = cvr_read(words, at >> 5) >> shift;
  if (shift + count > 32u) value |= cvr_read(words, (at >> 5) + 1u) << (32u - shift);
  return count == 32u ? value : value & ((1u << count) - 1u);
}

// Ones among the `count` <= 64 bits from bit `at` on.
CVR_FUNC uint cvr_ctx_ones(Words words, uint at, uint count) {
  uint first = count < 32u ? count : 32u;
  return cvr_popcount32(cvr_ctx_field(words, at, first)) + cvr_popcount32(cvr_ctx_field(words, at + first, count - first));
}

CVR_FUNC CtxGroup cvr_ctx_group(Words words, uint bricks, uint label_bits) {
  CtxGroup group;
  uint header = cvr_read(words, 0u);
  group.bricks = bricks;
  group.labels = (header & ((1u << CVR_CTX_LABELS_BITS) - 1u)) + 1u;
  group.rank_bits = cvr_ctx_bits_for(group.labels);
  group.size_bits = (header >> CVR_CTX_LABELS_BITS) & 31u;
  group.count_bits = (header >> (CVR_CTX_LABELS_BITS + CVR_CTX_SIZE_BITS)) & 31u;
  group.several_at = CVR_CTX_HEADER_BITS;
  group.turns_at = group.several_at + bricks;
  group.roots_at = group.turns_at + bricks - 1u;
  group.list_at = group.roots_at + group.rank_bits * (1u + cvr_ctx_ones(words, group.turns_at, bricks - 1u));
  group.records_at = group.list_at + group.labels * label_bits;
  return group;
}

// The m-th brick. m = group.bricks: what follows the last one.
CVR_FUNC CtxBrick cvr_ctx_brick(Words words, CtxGroup group, uint m) {
  CtxBrick brick;
  brick.labels = 1u;
  brick.bytes = 0u;
  bool constant = m == group.bricks || cvr_ctx_field(words, group.several_at + m, 1u) == 0u;
  uint own = cvr_ctx_ones(words, group.several_at, m);
  uint several = own + cvr_ctx_ones(words, group.several_at + m, group.bricks - m);
  uint bytes = 0u;
  uint entries = 0u;
  uint all_entries = 0u;
  for (uint i = 0u; i < several; ++i) {
    uint at = group.records_at + i * (group.size_bits + group.count_bits);
    uint size = cvr_ctx_field(words, at, group.size_bits);
    uint further = 1u + cvr_ctx_field(words, at + group.size_bits, group.count_bits);
    bytes += i < own ? size : 0u;
    entries += i < own ? further : 0u;
    all_entries += further;
    if (i == own && !constant) {
      brick.bytes = size;
      brick.labels = 1u + further;
    }
  }
  uint entries_at = group.records_at + several * (group.size_bits + group.count_bits);
  uint turns = cvr_ctx_ones(words, group.turns_at, m < group.bricks ? m : 0u);
  brick.root = cvr_ctx_field(words, group.roots_at + group.rank_bits * turns, group.rank_bits);
  brick.entries_at = entries_at + group.rank_bits * entries;
  brick.stream_at = (entries_at + group.rank_bits * all_entries + 7u) / 8u + bytes;
  return brick;
}

#endif
