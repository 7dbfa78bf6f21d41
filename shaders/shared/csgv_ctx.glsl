// `csgv-ctx`: where the parts of a group of bricks lie, and the serial decoder of one brick
// (codecs/csgv_ctx/FORMAT.md).
//
// A group:
// Bit fields from the group's first word on, first bit in the least significant place:
//   [18: labels - 1][5: s, bits of a size][5: c, bits of a count]
//   [a bit for each brick: 1 = it has more than one label][a bit for each brick but the first: 1 =
//   its root is not that of the brick before]
//   [r bits for each such root, and the first][label_bits for each label of the group]
//   [s + c bits for each brick with several labels: bytes of its stream, labels - 2][r bits for
//   each further palette entry]
// then, from the next byte on, the streams, and zeros to a word. r: bits that number the labels of
// the group; a root or an entry is the place of a label in the group's list.
#ifndef CVR_CSGV_CTX_GLSL
#define CVR_CSGV_CTX_GLSL

#include "shaders/shared/brick_limits.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/operations.glsl"
#include "shaders/shared/portable.glsl"

#define CVR_CTX_LABELS_BITS 18u
#define CVR_CTX_SIZE_BITS 5u
#define CVR_CTX_HEADER_BITS 28u

struct CtxGroup {
  uint bricks;
  uint labels;      // of the list
  uint rank_bits;   // r
  uint size_bits;   // s
  uint count_bits;  // c
  uint
      several_at;  // bit at which the first bit for each brick lies; the others are bit positions too
  uint turns_at;
  uint roots_at;
  uint list_at;
  uint records_at;
};

struct CtxBrick {
  uint root;        // of its palette's entries the first: place in the group's list
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
  return cvr_popcount32(cvr_ctx_field(words, at, first)) +
         cvr_popcount32(cvr_ctx_field(words, at + first, count - first));
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
  group.list_at =
      group.roots_at + group.rank_bits * (1u + cvr_ctx_ones(words, group.turns_at, bricks - 1u));
  group.records_at = group.list_at + group.labels * label_bits;
  return group;
}

// The root of the m-th brick: its place in the group's list.
CVR_FUNC uint cvr_ctx_root(Words words, CtxGroup group, uint m) {
  uint turns = cvr_ctx_ones(words, group.turns_at, m);
  return cvr_ctx_field(words, group.roots_at + group.rank_bits * turns, group.rank_bits);
}

// The m-th brick.
CVR_FUNC CtxBrick cvr_ctx_brick(Words words, CtxGroup group, uint m) {
  CtxBrick brick;
  brick.root = cvr_ctx_root(words, group, m);
  brick.labels = 1u;
  brick.bytes = 0u;
  bool constant = cvr_ctx_field(words, group.several_at + m, 1u) == 0u;
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
  brick.entries_at = entries_at + group.rank_bits * entries;
  brick.stream_at = (entries_at + group.rank_bits * all_entries + 7u) / 8u + bytes;
  return brick;
}

// Place of the k-th palette entry in the group's list.
CVR_FUNC uint cvr_ctx_entry(Words words, CtxGroup group, CtxBrick brick, uint k) {
  return k == 0u
             ? brick.root
             : cvr_ctx_field(words, brick.entries_at + (k - 1u) * group.rank_bits, group.rank_bits);
}

// Where the tables of the volume lie in their buffer, in words:
//   0           2^14 classes: bits 0..13 the dynamic bits that the class asks for, from 14 on its first row
//   rows_at     distributions of the rows, a byte each
//   slots_at    512 words a distribution: the symbol of each of its 4096 slots, a nibble each
//   symbols_at  16 words a distribution: first slot of a symbol | frequency << 16
struct CtxTables {
  uint rows_at;
  uint slots_at;
  uint symbols_at;
  uint numbers;  // first distribution of references
  uint label_bits;
};

// The words that hold the byte `next` and those behind it are kept: a renormalisation reads at most
// one more.
struct CtxStream {
  uint state;
  uint next;  // byte
  uint end;
  uint low;   // the word of that byte
  uint high;  // the one behind it
};

// The palette while a brick is decoded.
struct CtxPalette {
  uint in_use;  // entries
  uint last;    // label of the newest one
};

#define CVR_CTX_DYNAMIC_BITS 14u
#define CVR_CTX_PROBABILITY_BITS 12u
#define CVR_CTX_MOST_ASKED 7u  // dynamic bits of a class
#define CVR_CTX_WIDE 15u       // from this width on numbers have CVR_CTX_WIDE_BITS bits
#define CVR_CTX_WIDE_BITS 24u
#define CVR_CTX_NUMBER_KINDS 8u

// The word i, or 0 where the stream has ended before.
CVR_FUNC uint cvr_ctx_word(Words words, uint i, uint end) {
  return 4u * i < end ? cvr_read(words, i) : 0u;
}

CVR_FUNC uint cvr_ctx_bytes(CtxStream stream) {
  uint shift = 8u * (stream.next & 3u);
  return shift == 0u ? stream.low : (stream.low >> shift) | (stream.high << (32u - shift));
}

CVR_FUNC CtxStream cvr_ctx_begin(Words words, uint at, uint bytes) {
  CtxStream stream;
  stream.next = at;
  stream.end = at + bytes;
  stream.low = cvr_ctx_word(words, at >> 2, stream.end);
  stream.high = cvr_ctx_word(words, (at >> 2) + 1u, stream.end);
  uint length = bytes < 4u ? bytes : 4u - (bytes & 1u);
  stream.state = length == 0u ? 0u : cvr_ctx_bytes(stream) & (0xffffffffu >> (32u - 8u * length));
  stream.next += length;
  stream.low = cvr_ctx_word(words, stream.next >> 2, stream.end);
  stream.high = cvr_ctx_word(words, (stream.next >> 2) + 1u, stream.end);
  return stream;
}

CVR_FUNC void cvr_ctx_advance(Words words, uint frequency, uint place,
                              CVR_INOUT(CtxStream) stream) {
  stream.state = frequency * (stream.state >> CVR_CTX_PROBABILITY_BITS) + place;
  if (stream.state < 0x10000u && stream.next != stream.end) {
    stream.state = (stream.state << 16) | (cvr_ctx_bytes(stream) & 0xffffu);
    stream.next += 2u;
    if ((stream.next & 2u) == 0u) {
      stream.low = stream.high;
      stream.high = cvr_ctx_word(words, (stream.next >> 2) + 1u, stream.end);
    }
  }
}

CVR_FUNC uint cvr_ctx_symbol(Words words, Global tables, CtxTables at, uint distribution,
                             CVR_INOUT(CtxStream) stream) {
  uint slot = stream.state & ((1u << CVR_CTX_PROBABILITY_BITS) - 1u);
  uint symbol = (cvr_read_global(tables, at.slots_at + 512u * distribution + (slot >> 3)) >>
                 (4u * (slot & 7u))) &
                15u;
  uint range = cvr_read_global(tables, at.symbols_at + 16u * distribution + symbol);
  cvr_ctx_advance(words, range >> 16, slot - (range & 0xffffu), stream);
  return symbol;
}

// The distribution of a symbol in its context.
CVR_FUNC uint cvr_ctx_distribution(Global tables, CtxTables at, uint static_bits,
                                   uint dynamic_bits) {
  uint of_class = cvr_read_global(tables, static_bits);
  uint asked = of_class & ((1u << CVR_CTX_DYNAMIC_BITS) - 1u);
  uint row = of_class >> CVR_CTX_DYNAMIC_BITS;
  CVR_UNROLL for (uint k = 0u; k < CVR_CTX_MOST_ASKED; ++k) {
    uint lowest = asked & (0u - asked);
    row += (dynamic_bits & lowest) != 0u ? 1u << k : 0u;
    asked ^= lowest;
  }
  return (cvr_read_global(tables, at.rows_at + (row >> 2)) >> (8u * (row & 3u))) & 255u;
}

// Entries before the newest that a reference means; `in_use` >= 2 of `most` entries are in use.
CVR_FUNC uint cvr_ctx_reference(Words words, Global tables, CtxTables at, uint in_use, uint most,
                                CVR_INOUT(CtxStream) stream) {
  uint bound = in_use - 1u;
  if (bound < 2u) return 1u;
  uint kind = cvr_ctx_bits_for(bound) - 1u;
  uint width = cvr_ctx_symbol(
      words, tables, at,
      at.numbers + (kind < CVR_CTX_NUMBER_KINDS ? kind : CVR_CTX_NUMBER_KINDS - 1u), stream);
  uint value = width == 0u || width == CVR_CTX_WIDE ? 0u : 1u;
  uint left = width == CVR_CTX_WIDE ? CVR_CTX_WIDE_BITS : (width > 0u ? width - 1u : 0u);
  CVR_UNROLL for (uint part = 0u; part < 2u; ++part) {
    uint count = left < CVR_CTX_PROBABILITY_BITS ? left : CVR_CTX_PROBABILITY_BITS;
    bool possible =
        part == 0u || most > 1u << CVR_CTX_PROBABILITY_BITS;  // small bricks have no such numbers
    if (possible && count > 0u) {
      uint rest = CVR_CTX_PROBABILITY_BITS - count;
      uint slot = stream.state & ((1u << CVR_CTX_PROBABILITY_BITS) - 1u);
      value = (value << count) | (slot >> rest);
      cvr_ctx_advance(words, 1u << rest, slot & ((1u << rest) - 1u), stream);
      left -= count;
    }
  }
  return value + 1u;
}

// What a brick is decoded from. `words`: of its group.
struct CtxDecoding {
  CtxGroup group;
  CtxBrick brick;
  CtxTables tables;
  uint levels;   // L
  uint target;   // the level to decode, 0 the coarsest
  uint valid_x;  // voxels of the brick inside the volume along each axis, 1 .. 2^(L-1)
  uint valid_y;
  uint valid_z;
};

// The label code at a place of the group's list.
CVR_FUNC uint cvr_ctx_list_label(Words words, Global volume_labels, CtxGroup group, uint place,
                                 uint label_bits) {
  return cvr_read_global(volume_labels,
                         cvr_ctx_field(words, group.list_at + place * label_bits, label_bits));
}

CVR_FUNC uint cvr_ctx_label(Words words, Global volume_labels, CtxDecoding d, uint entry) {
  return cvr_ctx_list_label(words, volume_labels, d.group,
                            cvr_ctx_entry(words, d.group, d.brick, entry), d.tables.label_bits);
}

// What is known of a child before its siblings are.
struct CtxChild {
  uint candidates[3];
  uint across[3];  // the candidate of its sibling along each axis
  uint none;       // mask of the axes along which its own does not exist
};

// What is known of the siblings that have been decoded.
struct CtxSiblings {
  uint other;   // mask of those that do not have the parent's label
  uint newest;  // label of the last of these
};

// A level that is decoded, and its parents' level.
struct CtxLevel {
  uint depth;    // of a context: 0 the finest, 3 all from the third above it on
  uint shift;    // node n keeps its label at n << shift; above the target a stop bit at 1 behind it
  uint parents;  // nodes of the level above
  SerialLimits limits;
  SerialLimits parent_limits;
};

CVR_FUNC CtxLevel cvr_ctx_level(CtxDecoding d, uint l) {
  uint below = d.levels - 1u - l;
  CtxLevel level;
  level.depth = below < 3u ? below : 3u;
  level.shift = 3u * (d.target - l);
  level.parents = 1u << (3u * (l - 1u));
  level.limits = cvr_serial_limits(d.valid_x, d.valid_y, d.valid_z, below);
  level.parent_limits = cvr_serial_limits(d.valid_x, d.valid_y, d.valid_z, below + 1u);
  return level;
}

// The labels around the children of node n: `above` of the next node along an axis, `near` of the
// child that stands before `child`, which lies at 0 of the axis. The parent's where there is none.
CVR_FUNC uint cvr_ctx_above(Labels labels, CtxLevel level, uint n, uint axis, uint parent,
                            CVR_OUT(bool) exists) {
  uint mask = CVR_MORTON_X << axis;
  uint inside = level.parents - 1u;
  uint next = cvr_morton_plus(n, axis) & inside;
  exists = (n & mask) != (mask & inside) && cvr_serial_is_inside(level.parent_limits, next);
  uint label = parent;
  if (exists) label = cvr_load(labels, next << (level.shift + 3u));
  return label;
}
CVR_FUNC uint cvr_ctx_near(Labels labels, CtxLevel level, uint child, uint axis, uint parent) {
  uint label = parent;
  if (((child >> 3) & (CVR_MORTON_X << axis)) != 0u)
    label = cvr_load(labels, cvr_morton_minus(child, axis) << level.shift);
  return label;
}

CVR_FUNC uint cvr_ctx_static_bits(CtxChild child, uint c, uint parent, uint depth) {
  uint bits = (c << 9) | (depth << 12);
  CVR_UNROLL for (uint a = 0u; a < 3u; ++a) {
    bool differs = child.candidates[a] != parent;
    bits |= (differs ? 1u : 0u) << a;
    bits |= (differs ? (child.candidates[a] == child.candidates[(a + 1u) % 3u] ? 1u : 0u)
                     : (child.none >> a) & 1u)
            << (3u + a);
    bits |= (child.across[a] != parent ? 1u : 0u) << (6u + a);
  }
  return bits;
}

CVR_FUNC uint cvr_ctx_dynamic_bits(CtxChild child, uint c, uint parent, CtxSiblings siblings,
                                   CtxPalette palette, uint entries) {
  uint bits = 0u;
  bool known = palette.last == parent;
  CVR_UNROLL for (uint a = 0u; a < 3u; ++a) {
    bits |= (siblings.other != 0u && child.candidates[a] == siblings.newest ? 1u : 0u) << (7u + a);
    known = known || palette.last == child.candidates[a];
  }
  CVR_UNROLL for (uint k = 1u; k < 8u; ++k) {
    if ((c ^ k) < c) bits |= ((siblings.other >> (c ^ k)) & 1u) << (k - 1u);
  }
  bits |= (siblings.other != 0u && siblings.newest == palette.last ? 1u : 0u) << 10;
  bits |= (known ? 1u : 0u) << 11;
  bits |= (palette.in_use == entries ? 1u : 0u) << 12;
  bits |= (palette.in_use == 1u ? 1u : 0u) << 13;
  return bits;
}

// The label of an operation that copies.
CVR_FUNC uint cvr_ctx_copied(CtxChild child, uint operation, uint parent) {
  uint label = parent;
  CVR_UNROLL for (uint a = 0u; a < 3u; ++a) label =
      operation == CVR_OP_NEIGHBOUR_X + a ? child.candidates[a] : label;
  return label;
}

// The label of an operation that asks the palette.
CVR_FUNC uint cvr_ctx_from_palette(Words words, Global volume_labels, Global tables, CtxDecoding d,
                                   uint operation, CVR_INOUT(CtxPalette) palette,
                                   CVR_INOUT(CtxStream) stream) {
  bool advances = operation == CVR_OP_ADVANCE && palette.in_use < d.brick.labels;
  uint back = 0u;
  if (operation == CVR_OP_DELTA && palette.in_use >= 2u) {
    back = cvr_ctx_reference(words, tables, d.tables, palette.in_use, 1u << (3u * (d.levels - 1u)),
                             stream);
  }
  uint label = palette.last;
  if (operation == CVR_OP_DELTA || advances) {
    uint from_newest = back < palette.in_use ? palette.in_use - 1u - back : 0u;
    label = cvr_ctx_label(words, volume_labels, d, advances ? palette.in_use : from_newest);
  }
  palette.last = advances ? label : palette.last;
  palette.in_use += advances ? 1u : 0u;
  return label;
}

// The child number without the bit of an axis.
CVR_FUNC uint cvr_ctx_without(uint c, uint axis) {
  return (c & ((1u << axis) - 1u)) | ((c >> (axis + 1u)) << axis);
}

// Stores the label of a node and, above the target, whether it carries a stop bit.
CVR_FUNC void cvr_ctx_put(Labels labels, CtxLevel level, uint n, uint label, uint stop) {
  cvr_store(labels, n << level.shift, label);
  if (level.shift > 0u) cvr_store(labels, (n << level.shift) + 1u, stop);
}

// The children of an open node n with the label `parent`.
CVR_FUNC void cvr_ctx_block(Words words, Global volume_labels, Global tables, CtxDecoding d,
                            Labels labels, CtxLevel level, uint n, uint parent,
                            CVR_INOUT(CtxPalette) palette, CVR_INOUT(CtxStream) stream) {
  // Children at 1 of an axis have one candidate in common, children at 0 each their own.
  uint above[3];
  uint near[12];
  uint none_above = 0u;
  CVR_UNROLL for (uint a = 0u; a < 3u; ++a) {
    bool exists;
    above[a] = cvr_ctx_above(labels, level, n, a, parent, exists);
    none_above |= exists ? 0u : 1u << a;
    CVR_UNROLL for (uint j = 0u; j < 4u; ++j) {
      uint c = (j & ((1u << a) - 1u)) | ((j >> a) << (a + 1u));
      near[4u * a + j] = cvr_ctx_near(labels, level, 8u * n + c, a, parent);
    }
  }
  CtxSiblings siblings;
  siblings.other = 0u;
  siblings.newest = 0u;
  CVR_UNROLL for (uint c = 0u; c < 8u; ++c) {
    uint label = parent;
    uint stop = 0u;
    if (cvr_serial_is_inside(level.limits, 8u * n + c)) {
      CtxChild child;
      child.none = 0u;
      CVR_UNROLL for (uint a = 0u; a < 3u; ++a) {
        bool high = ((c >> a) & 1u) == 1u;
        uint beside = near[4u * a + cvr_ctx_without(c, a)];
        child.candidates[a] = high ? above[a] : beside;
        child.across[a] = high ? beside : above[a];
        child.none |=
            high ? none_above & (1u << a) : ((n & (CVR_MORTON_X << a)) == 0u ? 1u << a : 0u);
      }
      uint static_bits = cvr_ctx_static_bits(child, c, parent, level.depth);
      uint dynamic_bits = cvr_ctx_dynamic_bits(child, c, parent, siblings, palette, d.brick.labels);
      uint symbol =
          cvr_ctx_symbol(words, tables, d.tables,
                         cvr_ctx_distribution(tables, d.tables, static_bits, dynamic_bits), stream);
      stop = symbol >> 3;
      label = cvr_ctx_copied(child, symbol & 7u, parent);
      if ((symbol & 7u) >= CVR_OP_ADVANCE)
        label = cvr_ctx_from_palette(words, volume_labels, tables, d, symbol & 7u, palette, stream);
      if (label != parent) {
        siblings.other |= 1u << c;
        siblings.newest = label;
      }
    }
    cvr_ctx_put(labels, level, 8u * n + c, label, stop);
  }
}

// Gives the children of a stopped node its label.
CVR_FUNC void cvr_ctx_hand_down(Labels labels, CtxLevel level, uint n) {
  uint label = cvr_load(labels, n << (level.shift + 3u));
  CVR_UNROLL for (uint c = 0u; c < 8u; ++c) cvr_ctx_put(labels, level, 8u * n + c, label, 1u);
}

// Whether a node of the level above has children of its own in the stream.
CVR_FUNC bool cvr_ctx_is_open(Labels labels, CtxLevel level, uint n) {
  return cvr_load(labels, (n << (level.shift + 3u)) + 1u) == 0u &&
         cvr_serial_is_inside(level.parent_limits, n);
}

// Decodes one brick: label codes of the nodes of level d.target, in Morton order. It works in
// place: node n of a level that is k levels above the target keeps its label at n * 8^k and, for k
// > 0, whether an ancestor or itself carries a stop bit at n * 8^k + 1. Each level takes two
// sweeps. The first, backwards, hands the labels of stopped nodes down and puts at n * 8^k + 1 of
// an open node which open node comes next; the second goes along the open nodes. So invocations
// that decode bricks side by side do not wait for each other at every node.
CVR_FUNC void cvr_ctx_decode(Words words, Global volume_labels, Global tables, CtxDecoding d,
                             Labels labels) {
  CtxPalette palette;
  palette.last = cvr_ctx_label(words, volume_labels, d, 0u);
  palette.in_use = 1u;
  cvr_store(labels, 0u, palette.last);
  if (d.target > 0u) cvr_store(labels, 1u, d.brick.labels == 1u ? 1u : 0u);
  CtxStream stream = cvr_ctx_begin(words, d.brick.stream_at, d.brick.bytes);
  for (uint l = 1u; l <= d.target; ++l) {
    CtxLevel level = cvr_ctx_level(d, l);
    uint open = level.parents;
    for (uint i = (level.parents + 1u) >> 1; i > 0u; --i) {
      CVR_UNROLL for (uint k = 1u; k <= 2u; ++k) {
        uint n = 2u * i - k;
        if (n < level.parents) {
          if (cvr_ctx_is_open(labels, level, n)) {
            cvr_store(labels, (n << (level.shift + 3u)) + 1u, open);
            open = n;
          } else {
            cvr_ctx_hand_down(labels, level, n);
          }
        }
      }
    }
    for (uint n = open; n < level.parents;) {
      uint at = n << (level.shift + 3u);
      uint next = cvr_load(labels, at + 1u);
      cvr_ctx_block(words, volume_labels, tables, d, labels, level, n, cvr_load(labels, at),
                    palette, stream);
      n = next;
    }
  }
}

#endif
