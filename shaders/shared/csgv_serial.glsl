// The serial decoder of one brick: all nodes of one level in one sweep, by one thread (CSGV-R
// paper, section 2.5).
//
// It works in place in 8^target labels. While it builds level l, k = target - l levels above its
// goal, node n of level l keeps its label at n * 8^k and, for k > 0, whether an ancestor or itself
// carries a stop bit at n * 8^k + 1. The children of a node are written over these two places once
// they are read. What an operation refers to is still there: the neighbour at -1 has an earlier
// Morton code on the same level, so it is decoded; the parent's neighbour at +1 has a later one, so
// its place still holds the parent's level.
//
// No include guard: the text is included once for each source of symbols, which is chosen by
// defining one of
//   CVR_SERIAL_NIBBLE        nibbles with stop bits (`csgv-nibble`); nodes outside the volume have none
//   CVR_SERIAL_RANS          the same symbols behind range ANS (`csgv-rans`)
//   CVR_SERIAL_CSGVR_NIBBLE  nibbles without stop bits, every node has one
//   CVR_SERIAL_WAVELET       the wavelet matrix and stop bits of CSGV-R, every node has a symbol
//   CVR_SERIAL_CSGVR_C       the blocks of `csgvr-c`, every node has a symbol; labels come from a dictionary
// Whatever the words hold, no read leaves the brick's `word_count` words and no loop depends on
// more than them, provided that the header and the palette fit (csgv) or that the brick was checked
// on opening (csgvr).

#include "shaders/shared/brick_limits.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/operations.glsl"
#include "shaders/shared/portable.glsl"
#ifdef CVR_SERIAL_WAVELET
#include "shaders/shared/csgvr.glsl"
#endif
#ifdef CVR_SERIAL_CSGVR_C
#include "shaders/shared/csgvr_c.glsl"
#endif

struct SerialBrick {
  uint word_count;  // of the whole brick
  uint levels;      // L
  uint target;      // the level to decode, 0 the coarsest
  uint palette_size;
  bool stop_bits;  // CVR_SERIAL_WAVELET: whether the brick has them
  bool delta;      // nibble and rANS: operation 6 refers to older palette entries
  uint valid_x;    // voxels of the brick inside the volume along each axis, 1 .. 2^(L-1)
  uint valid_y;
  uint valid_z;
#ifdef CVR_SERIAL_CSGVR_C
  CsgvrcBrick opened;
#endif
};

#if defined(CVR_SERIAL_NIBBLE) || defined(CVR_SERIAL_CSGVR_NIBBLE)

struct SymbolCursor {
  uint word;  // the nibbles of the current word that are left
  uint next;  // nibbles taken, from the brick's begin
  uint end;   // 8 * word at which the palette begins
};

CVR_FUNC SymbolCursor cvr_symbols_begin(SerialBrick brick) {
  SymbolCursor cursor;
  cursor.word = 0u;
  cursor.next = 8u * (brick.levels + 1u);
  cursor.end = 8u * (brick.word_count - brick.palette_size);
  return cursor;
}

CVR_FUNC uint cvr_symbols_next(Words words, CVR_INOUT(SymbolCursor) cursor) {
  if ((cursor.next & 7u) == 0u) {
    if (cursor.next >= cursor.end) return 0u;
    cursor.word = cvr_read(words, cursor.next >> 3);
  }
  uint symbol = cursor.word & 15u;
  cursor.word >>= 4;
  cursor.next += 1u;
#ifdef CVR_SERIAL_CSGVR_NIBBLE
  symbol &= 7u;
#endif
  return symbol;
}

#elif defined(CVR_SERIAL_RANS)

// Tables: 2 x 2^14 slots, coarse levels first; bits 0..3 the symbol, 4..17 its frequency - 1,
// 18..31 the slot's place in it.
struct SymbolCursor {
  uint state;
  uint next;        // bytes from the brick's begin
  uint end;         // the byte at which the stream ends at the latest
  uint first_slot;  // of the table in use
};

#define CVR_RANS_LOWER_BOUND 0x800000u

CVR_FUNC uint cvr_symbols_byte(Words words, uint i) {
  return (cvr_read(words, i >> 2) >> (8u * (i & 3u))) & 255u;
}

// Reads the state with which a stream begins; an empty stream has none, and no symbols.
CVR_FUNC void cvr_symbols_state(Words words, CVR_INOUT(SymbolCursor) cursor) {
  cursor.state = CVR_RANS_LOWER_BOUND;
  if (cursor.next + 4u > cursor.end) return;
  cursor.state = 0u;
  for (uint i = 0u; i < 4u; ++i)
    cursor.state |= cvr_symbols_byte(words, cursor.next + i) << (8u * i);
  cursor.next += 4u;
}

// The byte, from the brick's begin, at which the fine stream begins.
CVR_FUNC uint cvr_symbols_fine(Words words, SerialBrick brick) {
  uint first = 4u * (brick.levels + 1u);
  uint length = 4u * (brick.word_count - brick.palette_size) - first;
  uint fine = cvr_read(words, brick.levels - 1u);
  return first + (fine < length ? fine : length);
}

CVR_FUNC SymbolCursor cvr_symbols_begin(Words words, SerialBrick brick) {
  SymbolCursor cursor;
  cursor.next = 4u * (brick.levels + 1u);
  cursor.end = cvr_symbols_fine(words, brick);
  cursor.first_slot = 0u;
  cvr_symbols_state(words, cursor);
  return cursor;
}

CVR_FUNC void cvr_symbols_begin_finest(Words words, SerialBrick brick,
                                       CVR_INOUT(SymbolCursor) cursor) {
  cursor.next = cvr_symbols_fine(words, brick);
  cursor.end = 4u * (brick.word_count - brick.palette_size);
  cursor.first_slot = 1u << 14;
  cvr_symbols_state(words, cursor);
}

CVR_FUNC void cvr_symbols_renormalise(Words words, CVR_INOUT(SymbolCursor) cursor) {
  if (cursor.state >= CVR_RANS_LOWER_BOUND || cursor.next >= cursor.end) return;
  cursor.state = (cursor.state << 8) | cvr_symbols_byte(words, cursor.next);
  cursor.next += 1u;
}

CVR_FUNC uint cvr_symbols_next(Words words, Global tables, CVR_INOUT(SymbolCursor) cursor) {
  uint slot = cvr_read_global(tables, cursor.first_slot + (cursor.state & 0x3fffu));
  cursor.state = (((slot >> 4) & 0x3fffu) + 1u) * (cursor.state >> 14) + (slot >> 18);
  // A state of at least 2^23 is at least 2^9 now: two bytes are enough.
  cvr_symbols_renormalise(words, cursor);
  cvr_symbols_renormalise(words, cursor);
  return slot & 15u;
}

#elif defined(CVR_SERIAL_WAVELET)

// The number of zeros before the first one is the operation; each wavelet level is read in order,
// so it needs one cursor.
struct SymbolCursor {
  uint stop;  // bit of S; this and the following count from the brick's begin
  uint level_0;
  uint level_1;
  uint level_2;
  uint level_3;
  uint level_4;
};

CVR_FUNC uint cvr_symbols_bit(Words words, uint i) {
  return (cvr_read(words, i >> 5) >> (i & 31u)) & 1u;
}

CVR_FUNC SymbolCursor cvr_symbols_begin(Words words, SerialBrick brick) {
  CsgvrBrick opened = cvr_csgvr_open(words, brick.word_count, brick.levels, brick.stop_bits);
  uint w = 32u * opened.w.bits_at;
  uint starts = opened.z_at + CVR_WAVELET_LEVELS;
  SymbolCursor cursor;
  cursor.stop = 32u * opened.s.bits_at;
  cursor.level_0 = w;
  cursor.level_1 = w + cvr_read(words, starts);
  cursor.level_2 = w + cvr_read(words, starts + 1u);
  cursor.level_3 = w + cvr_read(words, starts + 2u);
  cursor.level_4 = w + cvr_read(words, starts + 3u);
  return cursor;
}

CVR_FUNC uint cvr_symbols_operation(Words words, CVR_INOUT(SymbolCursor) cursor) {
  if (cvr_symbols_bit(words, cursor.level_0++) == 1u) return 0u;
  if (cvr_symbols_bit(words, cursor.level_1++) == 1u) return 1u;
  if (cvr_symbols_bit(words, cursor.level_2++) == 1u) return 2u;
  if (cvr_symbols_bit(words, cursor.level_3++) == 1u) return 3u;
  return 5u - cvr_symbols_bit(words, cursor.level_4++);
}

CVR_FUNC uint cvr_symbols_next(Words words, bool stop_bits, CVR_INOUT(SymbolCursor) cursor) {
  uint symbol = cvr_symbols_operation(words, cursor);
  if (stop_bits) symbol |= cvr_symbols_bit(words, cursor.stop++) << 3;
  return symbol;
}

#elif defined(CVR_SERIAL_CSGVR_C)

struct SymbolCursor {
  bool fine;
  uint next;        // block, among the coarse or the fine ones
  uint operations;  // of the children of the last block that are left
  uint open;        // which of them are open; the finest level: all
  uint at;          // bit of the next code
  uint labels_at;   // bit behind the next label of the run
  uint index;       // of the last label, in the dictionary
};

CVR_FUNC SymbolCursor cvr_symbols_begin(bool fine) {
  SymbolCursor cursor;
  cursor.fine = fine;
  cursor.next = 0u;
  cursor.operations = 0u;
  cursor.open = 255u;
  cursor.at = 0u;
  cursor.labels_at = 0u;
  cursor.index = 0u;
  return cursor;
}

// Reads the next block, of which all symbols are taken before the one after it is read.
CVR_FUNC void cvr_symbols_block(Words words, Global tables, CsgvrcBrick brick,
                                CVR_INOUT(SymbolCursor) cursor) {
  if ((cursor.next & (CVR_C_RUN - 1u)) == 0u) {
    CsgvrcRuns runs = cvr_c_runs(brick, cursor.fine);
    cursor.at = cvr_c_run_begin(words, runs, cursor.next >> CVR_C_RUN_SHIFT);
    cursor.labels_at = cvr_c_run_end(words, runs, cursor.next >> CVR_C_RUN_SHIFT);
  }
  cursor.operations = cvr_c_operations(words, tables, cursor.fine, cursor.at);
  if (!cursor.fine) cursor.open = cvr_c_mask(words, brick, cursor.next);
  cursor.next += 1u;
}

CVR_FUNC uint cvr_symbols_next(Words words, CsgvrcBrick brick, CVR_INOUT(SymbolCursor) cursor) {
  uint operation = cursor.operations & 7u;
  if (operation == CVR_OP_ADVANCE) {
    cursor.labels_at -= brick.index_bits;
    cursor.index = cvr_c_bits(words, cursor.labels_at, brick.index_bits);
  }
  uint stop = (cursor.open & 1u) ^ 1u;
  cursor.operations >>= 3;
  cursor.open = (cursor.open >> 1) | 128u;
  return operation | (stop << 3);
}

#endif

// What the functions below hand on to the source of symbols.
#if defined(CVR_SERIAL_CSGVR_C)
#define CVR_SERIAL_MEMORY Words words, Global tables
#define CVR_SERIAL_ARGUMENTS words, tables
#define CVR_NEXT_SYMBOL cvr_symbols_next(words, brick.opened, cursor)
#elif defined(CVR_SERIAL_RANS)
#define CVR_SERIAL_MEMORY Words words, Global tables
#define CVR_SERIAL_ARGUMENTS words, tables
#define CVR_NEXT_SYMBOL cvr_symbols_next(words, tables, cursor)
#else
#define CVR_SERIAL_MEMORY Words words
#define CVR_SERIAL_ARGUMENTS words
#ifdef CVR_SERIAL_WAVELET
#define CVR_NEXT_SYMBOL cvr_symbols_next(words, brick.stop_bits, cursor)
#else
#define CVR_NEXT_SYMBOL cvr_symbols_next(words, cursor)
#endif
#endif

#if defined(CVR_SERIAL_NIBBLE) || defined(CVR_SERIAL_RANS)
#define CVR_SERIAL_CSGV  // no symbols outside the volume, and deltas

// The digits after a delta operation: how far before the newest palette entry the meant one is,
// minus one.
CVR_FUNC uint cvr_serial_distance(CVR_SERIAL_MEMORY, SerialBrick brick,
                                  CVR_INOUT(SymbolCursor) cursor) {
  uint distance = 0u;
  uint digit;
  do {
    digit = CVR_NEXT_SYMBOL;
    distance = (distance << 3) | (digit & 7u);
  } while (digit >= 8u && distance != 0u &&
           distance <= brick.palette_size);  // no encoder goes on from 0 or from there
  return distance;
}

#endif

// The place of the node that a neighbour operation of child `child` (of node n) copies; `at` where
// it leaves the brick: no encoder writes that. `shift` is that of the child's level, `inside` the
// largest code of the parent's level.
CVR_FUNC uint cvr_serial_neighbour(uint child, uint axis, uint shift, uint inside, uint at) {
  uint mask = CVR_MORTON_X << axis;
  if (((child >> axis) & 1u) == 0u)
    return (child & mask) == 0u ? at : cvr_morton_minus(child, axis) << shift;
  uint n = child >> 3;
  return (n & mask) == (mask & inside) ? at : cvr_morton_plus(n, axis) << (shift + 3u);
}

// Decodes one brick: label codes of the nodes of level brick.target, in Morton order. `palette` and
// `words` are both the brick, which may lie in two memories; rANS needs its tables.
CVR_FUNC void cvr_serial_decode(Global palette, CVR_SERIAL_MEMORY, SerialBrick brick,
                                Labels labels) {
#ifdef CVR_SERIAL_CSGVR_C
  SymbolCursor cursor = cvr_symbols_begin(false);
  uint root = brick.opened.constant ? 8u : 0u;
  cvr_store(labels, 0u, cvr_c_label(palette, brick.opened, brick.opened.root));
#else
#if defined(CVR_SERIAL_NIBBLE) || defined(CVR_SERIAL_CSGVR_NIBBLE)
  SymbolCursor cursor = cvr_symbols_begin(brick);
#else
  SymbolCursor cursor = cvr_symbols_begin(words, brick);
#endif
  uint entries = 1u;  // of the palette that have been used; the root takes the first
  uint root = CVR_NEXT_SYMBOL;
  cvr_store(labels, 0u, cvr_read_global(palette, brick.word_count - 1u));
#endif
  if (brick.target > 0u) cvr_store(labels, 1u, root >> 3);
  for (uint l = 1u; l <= brick.target; ++l) {
#ifdef CVR_SERIAL_RANS
    if (l + 1u == brick.levels) cvr_symbols_begin_finest(words, brick, cursor);
#elif defined(CVR_SERIAL_CSGVR_C)
    if (l + 1u == brick.levels) cursor = cvr_symbols_begin(true);
#endif
#ifdef CVR_SERIAL_CSGV
    SerialLimits limits =
        cvr_serial_limits(brick.valid_x, brick.valid_y, brick.valid_z, brick.levels - 1u - l);
#endif
    uint shift = 3u * (brick.target - l);
    uint inside = (1u << (3u * (l - 1u))) - 1u;
    for (uint n = 0u; n <= inside; ++n) {
      uint at = n << (shift + 3u);
      uint parent_label = cvr_load(labels, at);
      uint parent_stop = cvr_load(labels, at + 1u);
#ifdef CVR_SERIAL_CSGVR_C
      if (parent_stop == 0u) cvr_symbols_block(words, tables, brick.opened, cursor);
#endif
      CVR_UNROLL for (uint c = 0u; c < 8u; ++c) {
        uint child = 8u * n + c;
        uint label = parent_label;
        uint stop = parent_stop;
        bool coded = stop == 0u;
#ifdef CVR_SERIAL_CSGV
        coded = coded && cvr_serial_is_inside(limits, child);
#endif
        if (coded) {
          uint symbol = CVR_NEXT_SYMBOL;
          uint operation = symbol & 7u;
          stop = symbol >> 3;
          if (operation >= CVR_OP_ADVANCE) {
#ifdef CVR_SERIAL_CSGVR_C
            label = cvr_c_label(palette, brick.opened, cursor.index);
#else
            uint back = 0u;  // entries before the newest
#ifdef CVR_SERIAL_CSGV
            if (operation == CVR_OP_DELTA && brick.delta)
              back = 1u + cvr_serial_distance(CVR_SERIAL_ARGUMENTS, brick, cursor);
#endif
            if (operation == CVR_OP_ADVANCE && entries < brick.palette_size) entries += 1u;
            uint entry = back < entries ? entries - 1u - back : 0u;
            label = cvr_read_global(palette, brick.word_count - 1u - entry);
#endif
          } else if (operation != CVR_OP_PARENT) {
            uint from =
                cvr_serial_neighbour(child, operation - CVR_OP_NEIGHBOUR_X, shift, inside, at);
            if (from != at) label = cvr_load(labels, from);
          }
        }
        cvr_store(labels, child << shift, label);
        if (shift > 0u) cvr_store(labels, (child << shift) + 1u, stop);
      }
    }
  }
}

#undef CVR_NEXT_SYMBOL
#undef CVR_SERIAL_MEMORY
#undef CVR_SERIAL_ARGUMENTS
#undef CVR_SERIAL_CSGV
