// Random access into one brick of `csgvr-c`: variable-length codes for whole 2x2x2 blocks, with a sample every few blocks.
//
// Blocks. Node k of the open (not constant) nodes of a brick, numbered from 0 over all levels, coarsest first and in Morton order,
// has block k: the operations of its eight children, 3 bits each, and, above the finest level, which of them are open. So the open
// children of block k have the numbers 1 + (open children of the blocks before k) and following. Operation 4 is a label of its own, 5
// the label of the last such child of the block; the others are those of csgvr.glsl.
//
// Content of a block: bits 0..23 the operations, bits 24..31 the open children (finest level: 0).
//
// Codes. Two prefix codes a volume, for the blocks of the finest level and of all others. Tables, in 32-bit words:
//   [2^11 entries, coarse][2^11 entries, fine][contents][further entries]
// An entry is looked up by the next 11 bits, first bit lowest: bits 0..4 length, 5..23 the word of the content, 24..27 labels of its own,
// 28..31 open children. Bits 28..31 = 15 are rare: with length 0 the code is longer, the next bits (their number in 24..27)
// lead to an entry from word 5..23 on; with another length it is an escape. A fine escape is followed by 24 bits of operations, a coarse
// one by 8 bits of open children and a fine code.
//
// Runs of 16 coarse and 32 fine blocks. A run ends with the dictionary indices of its blocks' own labels, the first last, so that the codes
// alone lie before the code that is asked for. Samples tell where a run begins, and how many open children are before it.
//
// Group of bricks, in bits from its first word, first bit lowest:
//   5  label bits - 1     5  index bits w     w  dictionary entries - 1     the labels of the dictionary
//   if w > 0: 6  bricks - 1     5  end bits E     5  position bits P     1 a brick: whether it is constant
//   E a brick that is not constant: its end, from the end of this table; w a constant brick: its label
//   the bricks that are not constant
// Brick of L levels:
//   3L-8  coarse blocks     3L-6  fine blocks - 1     w  label of the coarsest node     P  begin of the fine codes, from the first code
//   if more than 8 coarse runs: 5 offset bits, 17 offset slope, 5 opened bits, 12 opened slope
//   if more than 8 fine runs: 5 offset bits, 17 offset slope
//   the coarse samples (offset, opened), the fine samples (offset), of all runs but the first; the coarse runs; the fine runs
// Of up to 8 runs a sample has P and 3L-5 bits and tells the number; of more, the number is slope * run / 16 + sample - 2^(bits-1).
#ifndef CVR_CSGVR_C_GLSL
#define CVR_CSGVR_C_GLSL

#define CVR_C_LOOKUP_BITS 11u
#define CVR_C_LOOKUP 2048u
#define CVR_C_RARE 0xf0000000u      // entries from here on
#define CVR_C_COARSE_RUN_SHIFT 4u
#define CVR_C_FINE_RUN_SHIFT 5u
#define CVR_C_FEW_RUNS 8u
#define CVR_C_SLOPE_SHIFT 4u
#define CVR_C_MOST_CODE_BITS 16u
#define CVR_C_PATH 6u               // blocks from the coarsest level to the finest, bricks of 64^3

// Where the samples of the runs of one kind lie, and how they are read.
struct CsgvrcRuns {
  uint first;         // bit of the first run
  uint end;           // bit behind the last run
  uint count;
  uint samples;       // bit of the sample of run 1
  uint sample_bits;   // of one sample
  uint offset_bits;
  uint offset_slope;
};

struct CsgvrcBrick {
  uint levels;
  uint label_bits;
  uint index_bits;
  uint dictionary;        // its first bit
  uint dictionary_size;
  uint root;              // dictionary index of the coarsest node
  bool constant;          // what follows is of bricks that are not
  uint position_bits;
  uint coarse_blocks;
  uint fine_blocks;
  uint begin;             // of the brick's bits
  uint end;
  CsgvrcRuns coarse;
  CsgvrcRuns fine;
  uint opened_bits;
  uint opened_slope;
};

CVR_FUNC uint cvr_c_cut(uint64_t pair, uint at, uint count) {
  return uint(pair >> (at & 31u)) & uint((uint64_t(1u) << count) - uint64_t(1u));
}

// `count` <= 32 bits from bit `at` on. The word behind is read too.
CVR_FUNC uint cvr_c_bits(Words words, uint at, uint count) { return cvr_c_cut(cvr_word64(words, at >> 5), at, count); }
CVR_FUNC uint cvr_c_bits_global(Global words, uint at, uint count) {
  return cvr_c_cut(cvr_word64_global(words, at >> 5), at, count);
}

// The next `count` bits of a header.
CVR_FUNC uint cvr_c_take(Global words, CVR_INOUT(uint) at, uint count) {
  uint value = cvr_c_bits_global(words, at, count);
  at += count;
  return value;
}

CVR_FUNC CsgvrcRuns cvr_c_no_runs() {
  CsgvrcRuns runs;
  runs.first = 0u;
  runs.end = 0u;
  runs.count = 0u;
  runs.samples = 0u;
  runs.sample_bits = 0u;
  runs.offset_bits = 0u;
  runs.offset_slope = 0u;
  return runs;
}

// The header of a group, up to its dictionary.
CVR_FUNC CsgvrcBrick cvr_c_open_group(Global words, uint levels) {
  CsgvrcBrick brick;
  uint at = 0u;
  brick.levels = levels;
  brick.label_bits = cvr_c_take(words, at, 5u) + 1u;
  brick.index_bits = cvr_c_take(words, at, 5u);
  brick.dictionary_size = cvr_c_take(words, at, brick.index_bits) + 1u;
  brick.dictionary = at;
  brick.root = 0u;
  brick.constant = true;
  brick.position_bits = 0u;
  brick.coarse_blocks = 0u;
  brick.fine_blocks = 0u;
  brick.begin = at + brick.dictionary_size * brick.label_bits;
  brick.end = brick.begin;
  brick.coarse = cvr_c_no_runs();
  brick.fine = cvr_c_no_runs();
  brick.opened_bits = 0u;
  brick.opened_slope = 0u;
  return brick;
}

CVR_FUNC uint cvr_c_run_count(uint blocks, uint shift) { return (blocks + (1u << shift) - 1u) >> shift; }

// Reads how the samples of `runs` are stored: the two fields of each kind of number, where there are many runs.
CVR_FUNC void cvr_c_open_samples(Global words, CVR_INOUT(uint) at, uint position_bits, CVR_INOUT(CsgvrcRuns) runs) {
  runs.offset_bits = runs.count > 1u ? position_bits : 0u;
  if (runs.count > CVR_C_FEW_RUNS) {
    runs.offset_bits = cvr_c_take(words, at, 5u);
    runs.offset_slope = cvr_c_take(words, at, 17u);
  }
}

// Finds the brick `member` of a group: its bits, or of a constant brick its label.
CVR_FUNC CsgvrcBrick cvr_c_find(Global words, uint member, uint levels) {
  CsgvrcBrick brick = cvr_c_open_group(words, levels);
  if (brick.index_bits == 0u) return brick;
  uint at = brick.begin;
  uint members = cvr_c_take(words, at, 6u) + 1u;
  uint end_bits = cvr_c_take(words, at, 5u);
  brick.position_bits = cvr_c_take(words, at, 5u);
  uint low = cvr_c_take(words, at, members < 32u ? members : 32u);
  uint high = cvr_c_take(words, at, members < 32u ? 0u : members - 32u);
  uint before_low = member < 32u ? (1u << member) - 1u : ~0u;
  uint before_high = member < 32u ? 0u : (1u << (member - 32u)) - 1u;
  uint constants = cvr_popcount32(low) + cvr_popcount32(high);
  uint constants_before = cvr_popcount32(low & before_low) + cvr_popcount32(high & before_high);
  uint labels = at + (members - constants) * end_bits;
  brick.begin = labels + constants * brick.index_bits;
  brick.end = brick.begin;
  brick.constant = (((member < 32u ? low : high) >> (member & 31u)) & 1u) == 1u;
  if (brick.constant) {
    brick.root = cvr_c_bits_global(words, labels + constants_before * brick.index_bits, brick.index_bits);
    return brick;
  }
  at += (member - constants_before) * end_bits;
  brick.end += cvr_c_bits_global(words, at, end_bits);
  if (member > constants_before) brick.begin += cvr_c_bits_global(words, at - end_bits, end_bits);
  return brick;
}

// Reads the header of a brick that has been found and is not constant.
CVR_FUNC void cvr_c_open_brick(Global words, CVR_INOUT(CsgvrcBrick) brick) {
  uint levels = brick.levels;
  uint at = brick.begin;
  brick.coarse_blocks = cvr_c_take(words, at, 3u * levels - 8u);
  brick.fine_blocks = cvr_c_take(words, at, 3u * levels - 6u) + 1u;
  brick.root = cvr_c_take(words, at, brick.index_bits);
  uint fine = cvr_c_take(words, at, brick.position_bits);
  brick.coarse.count = cvr_c_run_count(brick.coarse_blocks, CVR_C_COARSE_RUN_SHIFT);
  brick.fine.count = cvr_c_run_count(brick.fine_blocks, CVR_C_FINE_RUN_SHIFT);
  cvr_c_open_samples(words, at, brick.position_bits, brick.coarse);
  brick.opened_bits = brick.coarse.count > 1u ? 3u * levels - 5u : 0u;
  if (brick.coarse.count > CVR_C_FEW_RUNS) {
    brick.opened_bits = cvr_c_take(words, at, 5u);
    brick.opened_slope = cvr_c_take(words, at, 12u);
  }
  cvr_c_open_samples(words, at, brick.position_bits, brick.fine);
  brick.coarse.sample_bits = brick.coarse.offset_bits + brick.opened_bits;
  brick.fine.sample_bits = brick.fine.offset_bits;
  brick.coarse.samples = at;
  brick.fine.samples = at + (brick.coarse.count - 1u) * brick.coarse.sample_bits;
  brick.coarse.first = brick.fine.samples + (brick.fine.count - 1u) * brick.fine.sample_bits;
  brick.fine.first = brick.coarse.first + fine;
  brick.coarse.end = brick.fine.first;
  brick.fine.end = brick.end;
}

// Reads the header of the brick `member` of a group.
CVR_FUNC CsgvrcBrick cvr_c_open(Global words, uint member, uint levels) {
  CsgvrcBrick brick = cvr_c_find(words, member, levels);
  if (!brick.constant) cvr_c_open_brick(words, brick);
  return brick;
}

// The words that hold a brick's bits, and the one behind them.
CVR_FUNC uint cvr_c_words(CsgvrcBrick brick) { return (brick.end + 31u) / 32u - brick.begin / 32u + 1u; }

// Moves a brick by `bits` towards the begin of its words, where only these have been copied.
CVR_FUNC void cvr_c_rebase(uint bits, CVR_INOUT(CsgvrcRuns) runs) {
  runs.first -= bits;
  runs.end -= bits;
  runs.samples -= bits;
}

// What a sample means.
CVR_FUNC uint cvr_c_sampled(uint value, uint bits, uint slope, uint run, uint runs) {
  return runs > CVR_C_FEW_RUNS ? ((slope * run) >> CVR_C_SLOPE_SHIFT) + value - ((1u << bits) >> 1) : value;
}

// The bit at which a run begins.
CVR_FUNC uint cvr_c_run_begin(Words words, CsgvrcRuns runs, uint run) {
  if (run == 0u) return runs.first;
  uint value = cvr_c_bits(words, runs.samples + (run - 1u) * runs.sample_bits, runs.offset_bits);
  return runs.first + cvr_c_sampled(value, runs.offset_bits, runs.offset_slope, run, runs.count);
}

// The bit behind a run.
CVR_FUNC uint cvr_c_run_end(Words words, CsgvrcRuns runs, uint run) {
  return run + 1u < runs.count ? cvr_c_run_begin(words, runs, run + 1u) : runs.end;
}

// Open children of the blocks before a coarse run.
CVR_FUNC uint cvr_c_opened_before(Words words, CsgvrcBrick brick, uint run) {
  if (run == 0u) return 0u;
  uint at = brick.coarse.samples + (run - 1u) * brick.coarse.sample_bits + brick.coarse.offset_bits;
  return cvr_c_sampled(cvr_c_bits(words, at, brick.opened_bits), brick.opened_bits, brick.opened_slope, run, brick.coarse.count);
}

// Bit 3c of each child c with a label of its own.
CVR_FUNC uint cvr_c_own_labels(uint content) { return (content >> 2) & ~(content >> 1) & ~content & 0x249249u; }

// The entry of the code that `bits` begin with, which may be longer than the lookup.
CVR_FUNC uint cvr_c_entry(Global tables, uint first, uint bits) {
  uint entry = cvr_read_global(tables, first + (bits & (CVR_C_LOOKUP - 1u)));
  if ((entry & 31u) != 0u) return entry;
  uint further = (bits >> CVR_C_LOOKUP_BITS) & ((1u << ((entry >> 24) & 15u)) - 1u);
  return cvr_read_global(tables, ((entry >> 5) & 0x7ffffu) + further);
}

// The content of the block whose code begins at bit `at`, which moves behind it.
CVR_FUNC uint cvr_c_content(Words words, Global tables, bool fine, CVR_INOUT(uint) at) {
  uint open = 0u;
  uint entry = cvr_c_entry(tables, fine ? CVR_C_LOOKUP : 0u, cvr_c_bits(words, at, CVR_C_MOST_CODE_BITS));
  at += entry & 31u;
  if (!fine && entry >= CVR_C_RARE) {
    uint bits = cvr_c_bits(words, at, 8u + CVR_C_MOST_CODE_BITS);
    open = bits << 24;
    entry = cvr_c_entry(tables, CVR_C_LOOKUP, bits >> 8);
    at += 8u + (entry & 31u);
  }
  if (entry < CVR_C_RARE) return cvr_read_global(tables, (entry >> 5) & 0x7ffffu) | open;
  uint operations = cvr_c_bits(words, at, 24u);
  at += 24u;
  return operations | open;
}

// Moves over `blocks` blocks from bit `at` on, and counts their labels and open children.
CVR_FUNC void cvr_c_skip(Words words, Global tables, bool fine, uint blocks, CVR_INOUT(uint) at, CVR_INOUT(uint) own_labels,
                         CVR_INOUT(uint) opened) {
  uint first = fine ? CVR_C_LOOKUP : 0u;
  uint64_t window = uint64_t(0u);
  uint left = 0u;  // bits of the window
  for (uint k = 0u; k < blocks; ++k) {
    if (left < CVR_C_LOOKUP_BITS) {
      window = cvr_word64(words, at >> 5) >> (at & 31u);
      left = 64u - (at & 31u);
    }
    uint entry = cvr_read_global(tables, first + (uint(window) & (CVR_C_LOOKUP - 1u)));
    if (entry < CVR_C_RARE) {
      uint length = entry & 31u;
      window >>= length;
      left -= length;
      at += length;
      own_labels += (entry >> 24) & 15u;
      opened += entry >> 28;
    } else {
      uint content = cvr_c_content(words, tables, fine, at);
      own_labels += cvr_popcount32(cvr_c_own_labels(content));
      opened += cvr_popcount32(content >> 24);
      left = 0u;
    }
  }
}

// One entry of an array whose index is no constant: a chain of choices where indexed registers are memory.
#ifdef __cplusplus
#define CVR_C_PICK(array, i) array[i]
#define CVR_C_PUT(array, i, value) array[i] = value
#else
#define CVR_C_PUT(array, i, value) \
  CVR_UNROLL for (uint place_ = 0u; place_ < CVR_C_PATH; ++place_) array[place_] = place_ == (i) ? (value) : array[place_]
uint cvr_c_pick(uint array[CVR_C_PATH], uint i) {
  uint value = array[0];
  CVR_UNROLL for (uint place = 1u; place < CVR_C_PATH; ++place) value = place == i ? array[place] : value;
  return value;
}
#define CVR_C_PICK(array, i) cvr_c_pick(array, i)
#endif

// The blocks on the way to a node: entry l - 1 is the block with its ancestor at level l.
struct CsgvrcPath {
  uint content[CVR_C_PATH];
  uint labels[CVR_C_PATH];   // its run << 8 | labels of its own before it in the run
  uint opened[CVR_C_PATH];   // open children of the blocks before
};

// Reads block `number` of level `level` into the path.
CVR_FUNC void cvr_c_read_block(Words words, Global tables, CsgvrcBrick brick, uint level, uint number, CVR_INOUT(CsgvrcPath) path) {
  bool fine = level + 1u == brick.levels;
  uint shift = fine ? CVR_C_FINE_RUN_SHIFT : CVR_C_COARSE_RUN_SHIFT;
  uint k = fine ? number - brick.coarse_blocks : number;
  uint run = k >> shift;
  uint opened = 0u;
  uint at;
  if (fine) {
    at = cvr_c_run_begin(words, brick.fine, run);
  } else {
    at = cvr_c_run_begin(words, brick.coarse, run);
    opened = cvr_c_opened_before(words, brick, run);
  }
  uint own_labels = 0u;
  cvr_c_skip(words, tables, fine, k & ((1u << shift) - 1u), at, own_labels, opened);
  uint content = cvr_c_content(words, tables, fine, at);
  CVR_C_PUT(path.content, level - 1u, content);
  CVR_C_PUT(path.labels, level - 1u, run << 8 | own_labels);
  CVR_C_PUT(path.opened, level - 1u, opened);
}

// The level down to which the paths to (n, level) and (m, deeper), not above it, share their blocks.
CVR_FUNC uint cvr_c_shared_level(uint n, uint level, uint m, uint deeper) {
  uint differs = (n ^ (m >> (3u * (deeper - level)))) >> 3;
  return differs == 0u ? level : level - (cvr_highest_bit(differs) / 3u + 1u);
}

// Dictionary index of a node's label. `hops` counts the operations read. False on a chain that no encoder writes.
CVR_FUNC bool cvr_c_index(Words words, Global tables, CsgvrcBrick brick, uint n, uint level, CVR_OUT(uint) index,
                          CVR_INOUT(uint) hops) {
  index = brick.root;
  if (brick.constant) return true;
  CsgvrcPath path;
  uint known = 0u;  // levels of the path that are n's
  while (level > 0u) {
    while (known < level) {
      uint number = 0u;
      if (known > 0u) {
        uint child = (n >> (3u * (level - known))) & 7u;
        uint open = CVR_C_PICK(path.content, known - 1u) >> 24;
        if (((open >> child) & 1u) == 0u) {  // constant: the label is the ancestor's
          n >>= 3u * (level - known);
          level = known;
          break;
        }
        number = 1u + CVR_C_PICK(path.opened, known - 1u) + cvr_popcount32(open & ((1u << child) - 1u));
      }
      known += 1u;
      cvr_c_read_block(words, tables, brick, known, number, path);
    }
    hops += 1u;
    uint content = CVR_C_PICK(path.content, level - 1u);
    uint child = n & 7u;
    uint operation = (content >> (3u * child)) & 7u;
    if (operation >= CVR_OP_ADVANCE) {
      uint labels = CVR_C_PICK(path.labels, level - 1u);
      uint before = cvr_popcount32(cvr_c_own_labels(content) & ((1u << (3u * child)) - 1u)) + (operation == CVR_OP_ADVANCE ? 1u : 0u);
      uint back = ((labels & 255u) + before) * brick.index_bits;
      uint end = level + 1u == brick.levels ? cvr_c_run_end(words, brick.fine, labels >> 8)
                                            : cvr_c_run_end(words, brick.coarse, labels >> 8);
      index = cvr_c_bits(words, end - back, brick.index_bits);
      return index < brick.dictionary_size;
    }
    uint m = n;
    uint deeper = level;
    if (!cvr_csgvr_follow(operation, n, level)) return false;
    known = cvr_c_shared_level(n, level, m, deeper);
  }
  return true;
}

// The label at a dictionary index. The dictionary is never copied to shared memory.
CVR_FUNC uint cvr_c_label(Global words, CsgvrcBrick brick, uint index) {
  return cvr_c_bits_global(words, brick.dictionary + index * brick.label_bits, brick.label_bits);
}

#endif
