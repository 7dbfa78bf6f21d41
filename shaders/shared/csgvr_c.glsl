// Random access into one brick of `csgvr-c`: variable-length codes for whole 2x2x2 blocks, with a
// sample every 8 blocks.
//
// Blocks. Node k of the open (not constant) nodes of a brick, numbered from 0 over all levels,
// coarsest first and in Morton order, has block k: the operations of its eight children, child 0 in
// the lowest of 8 x 3 bits. Operation 4 is a label of its own, 5 the label of the last such child
// of the block; the others are those of csgvr.glsl. Above the finest level a mask of 8 bits tells
// which children are open, so the open children of block k are the nodes 1 + (open children of the
// blocks before k) and following.
//
// Codes. Two prefix codes a volume, for the blocks of the finest level and of all others, of at
// most 13 bits, looked up by the next 13 bits, first bit lowest. Blocks without a code of their own
// have one of nine escapes, by the number of their own labels, and after it the 24 bits of their
// operations. Tables, each for the coarse code, then for the fine one:
//   2^13 x 16 bits: bits 0..5 length, with the 24 bits after an escape, 6..9 labels of its own
//   2^13 x 16 bits: place among the operations; 65535: an escape
//   32-bit words of operations, the first place at word 2^14
//
// Runs of 8 blocks, of the finest level and of the others apart. A run ends with the dictionary
// indices of its blocks' own labels, the first last, so that codes alone lie before the code that
// is asked for. Samples tell where a run begins.
//
// Group of bricks, in bits from its first word, first bit lowest:
//   5  label bits - 1     5  index bits w     0: one label follows, and nothing else
//   18  dictionary entries - 1     6  bricks - 1     5  end bits E     5  position bits P     1 a brick: whether it is constant
//   E a brick that is not constant: its end, from the begin of the first; w a constant brick: its
//   label
//   the labels of the dictionary; zeros to a multiple of 8 bits; the bricks that are not constant
// Brick of L levels:
//   3L-8  coarse blocks     3L-5  fine blocks     w  label of the coarsest node     P  begin of the fine runs, from the coarse ones
//   twice, coarse and fine: if there are more than 8 runs 5 sample bits, 17 slope
//   zeros to a multiple of 8 bits; the masks of the coarse blocks, after every 16 the open children
//   so far in 16 bits
//   the samples of all runs but the first, coarse and fine; the coarse runs; the fine runs
// Of up to 8 runs a sample is P bits and the run's begin, from the first; of more the begin is
// slope * run / 16 + sample - 2^(bits-1).
#ifndef CVR_CSGVR_C_GLSL
#define CVR_CSGVR_C_GLSL

#include "shaders/shared/morton.glsl"
#include "shaders/shared/operations.glsl"
#include "shaders/shared/portable.glsl"

#define CVR_C_CODE_BITS 13u  // at most
#define CVR_C_LOOKUP 8192u
#define CVR_C_PLACES 8192u       // word at which the places begin
#define CVR_C_OPERATIONS 16384u  // and the operations
#define CVR_C_NO_PLACE 65535u
#define CVR_C_RAW_BITS 24u
#define CVR_C_DICTIONARY_BITS 18u  // voxels of a group
#define CVR_C_RUN_SHIFT 3u
#define CVR_C_RUN 8u
#define CVR_C_FEW_RUNS 8u
#define CVR_C_SLOPE_SHIFT 4u
#define CVR_C_MASKS_SHIFT 4u  // masks of 16 blocks, and a count
#define CVR_C_MASKS 16u
#define CVR_C_MASKS_BITS 144u
#define CVR_C_COUNT_BITS 16u
#define CVR_C_PATH 6u  // blocks from the coarsest level to the finest, bricks of 64^3

// Where the samples of the runs of one kind lie, and how they are read.
struct CsgvrcRuns {
  uint first;  // bit of the first run
  uint end;    // bit behind the last run
  uint count;
  uint samples;  // bit of the sample of run 1
  uint sample_bits;
  uint slope;
};

struct CsgvrcBrick {
  uint levels;
  uint label_bits;
  uint index_bits;
  uint dictionary;  // its first bit
  uint dictionary_size;
  uint root;      // dictionary index of the coarsest node
  bool constant;  // what follows is of bricks that are not
  uint members;   // bricks of the group
  uint end_bits;
  uint position_bits;
  uint coarse_blocks;
  uint fine_blocks;
  uint begin;  // of the brick's bits
  uint end;
  CsgvrcRuns runs[2];  // coarse, fine
  uint masks;          // bit of the first mask
};

CVR_FUNC uint cvr_c_cut(uint64_t pair, uint at, uint count) {
  return uint(pair >> (at & 31u)) & uint((uint64_t(1u) << count) - uint64_t(1u));
}

// `count` <= 32 bits from bit `at` on. The word behind is read too.
CVR_FUNC uint cvr_c_bits(Words words, uint at, uint count) {
  return cvr_c_cut(cvr_word64(words, at >> 5), at, count);
}
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
  runs.slope = 0u;
  return runs;
}

// The header of a group, up to the table of its bricks, which is left to read from brick.begin on.
CVR_FUNC CsgvrcBrick cvr_c_open_group(Global words, uint levels) {
  uint64_t header = cvr_word64_global(words, 0u);
  CsgvrcBrick brick;
  brick.levels = levels;
  brick.label_bits = (uint(header) & 31u) + 1u;
  brick.index_bits = (uint(header) >> 5) & 31u;
  brick.dictionary = 10u;
  brick.dictionary_size = 1u;
  brick.root = 0u;
  brick.constant = true;
  brick.members = 1u;
  brick.end_bits = 0u;
  brick.position_bits = 0u;
  brick.begin = 44u;
  brick.end = 44u;
  if (brick.index_bits > 0u) {
    brick.dictionary_size = (uint(header >> 10) & ((1u << CVR_C_DICTIONARY_BITS) - 1u)) + 1u;
    brick.members = (uint(header >> 28) & 63u) + 1u;
    brick.end_bits = uint(header >> 34) & 31u;
    brick.position_bits = uint(header >> 39) & 31u;
  }
  brick.coarse_blocks = 0u;
  brick.fine_blocks = 0u;
  brick.runs[0] = cvr_c_no_runs();
  brick.runs[1] = cvr_c_no_runs();
  brick.masks = 0u;
  return brick;
}

// Reads how the samples of the runs of `blocks` blocks are stored.
CVR_FUNC void cvr_c_open_samples(Global words, CVR_INOUT(uint) at, uint blocks, uint position_bits,
                                 CVR_INOUT(CsgvrcRuns) runs) {
  runs.count = (blocks + CVR_C_RUN - 1u) >> CVR_C_RUN_SHIFT;
  runs.sample_bits = position_bits;
  if (runs.count > CVR_C_FEW_RUNS) {
    runs.sample_bits = cvr_c_take(words, at, 5u);
    runs.slope = cvr_c_take(words, at, 17u);
  }
}

// Finds the brick `member` of a group: its bits, or of a constant brick its label.
CVR_FUNC CsgvrcBrick cvr_c_find(Global words, uint member, uint levels) {
  CsgvrcBrick brick = cvr_c_open_group(words, levels);
  if (brick.index_bits == 0u) return brick;
  uint at = brick.begin;
  uint members = brick.members;
  uint low = cvr_c_take(words, at, members < 32u ? members : 32u);
  uint high = members > 32u ? cvr_c_take(words, at, members - 32u) : 0u;
  uint before_low = member < 32u ? (1u << member) - 1u : ~0u;
  uint before_high = member < 32u ? 0u : (1u << (member - 32u)) - 1u;
  uint constants = cvr_popcount32(low) + cvr_popcount32(high);
  uint constants_before = cvr_popcount32(low & before_low) + cvr_popcount32(high & before_high);
  uint labels = at + (members - constants) * brick.end_bits;
  brick.dictionary = labels + constants * brick.index_bits;
  brick.begin = (brick.dictionary + brick.dictionary_size * brick.label_bits + 7u) & ~7u;
  brick.end = brick.begin;
  brick.constant = (((member < 32u ? low : high) >> (member & 31u)) & 1u) == 1u;
  if (brick.constant) {
    brick.root =
        cvr_c_bits_global(words, labels + constants_before * brick.index_bits, brick.index_bits);
    return brick;
  }
  at += (member - constants_before) * brick.end_bits;
  brick.end += cvr_c_bits_global(words, at, brick.end_bits);
  if (member > constants_before)
    brick.begin += cvr_c_bits_global(words, at - brick.end_bits, brick.end_bits);
  return brick;
}

// Reads the header of a brick that has been found and is not constant.
CVR_FUNC void cvr_c_open_brick(Global words, CVR_INOUT(CsgvrcBrick) brick) {
  uint levels = brick.levels;
  uint at = brick.begin;
  brick.coarse_blocks = cvr_c_take(words, at, 3u * levels - 8u);
  brick.fine_blocks = cvr_c_take(words, at, 3u * levels - 5u);
  brick.root = cvr_c_take(words, at, brick.index_bits);
  uint fine = cvr_c_take(words, at, brick.position_bits);
  cvr_c_open_samples(words, at, brick.coarse_blocks, brick.position_bits, brick.runs[0]);
  cvr_c_open_samples(words, at, brick.fine_blocks, brick.position_bits, brick.runs[1]);
  brick.masks = (at + 7u) & ~7u;
  uint fine_samples = brick.runs[1].count == 0u ? 0u : brick.runs[1].count - 1u;
  brick.runs[0].samples = brick.masks + 8u * brick.coarse_blocks +
                          CVR_C_COUNT_BITS * ((brick.coarse_blocks - 1u) >> CVR_C_MASKS_SHIFT);
  brick.runs[1].samples =
      brick.runs[0].samples + (brick.runs[0].count - 1u) * brick.runs[0].sample_bits;
  brick.runs[0].first = brick.runs[1].samples + fine_samples * brick.runs[1].sample_bits;
  brick.runs[1].first = brick.runs[0].first + fine;
  brick.runs[0].end = brick.runs[1].first;
  brick.runs[1].end = brick.end;
}

// Reads the header of the brick `member` of a group.
CVR_FUNC CsgvrcBrick cvr_c_open(Global words, uint member, uint levels) {
  CsgvrcBrick brick = cvr_c_find(words, member, levels);
  if (!brick.constant) cvr_c_open_brick(words, brick);
  return brick;
}

// The words that hold a brick's bits, and the one behind them.
CVR_FUNC uint cvr_c_words(CsgvrcBrick brick) {
  return (brick.end + 31u) / 32u - brick.begin / 32u + 1u;
}

// Moves an opened brick by whole words towards their begin, where only these have been copied.
CVR_FUNC void cvr_c_rebase(CVR_INOUT(CsgvrcBrick) brick) {
  uint bits = brick.begin & ~31u;
  brick.masks -= bits;
  brick.runs[0].first -= bits;
  brick.runs[0].end -= bits;
  brick.runs[0].samples -= bits;
  brick.runs[1].first -= bits;
  brick.runs[1].end -= bits;
  brick.runs[1].samples -= bits;
}

// The bit at which a run begins.
CVR_FUNC uint cvr_c_run_begin(Words words, CsgvrcRuns runs, uint run) {
  if (run == 0u) return runs.first;
  uint offset = cvr_c_bits(words, runs.samples + (run - 1u) * runs.sample_bits, runs.sample_bits);
  if (runs.count > CVR_C_FEW_RUNS)
    offset += ((runs.slope * run) >> CVR_C_SLOPE_SHIFT) - ((1u << runs.sample_bits) >> 1);
  return runs.first + offset;
}

// The bit behind a run.
CVR_FUNC uint cvr_c_run_end(Words words, CsgvrcRuns runs, uint run) {
  return run + 1u < runs.count ? cvr_c_run_begin(words, runs, run + 1u) : runs.end;
}

// The ones of the `count` < 128 bits from bit `at` on, a multiple of 8; bit `at + count` itself.
CVR_FUNC uint cvr_c_ones(Words words, uint at, uint count, CVR_OUT(uint) bit) {
#ifdef __cplusplus
  uint64_t low, high;
  const char* bytes = reinterpret_cast<const char*>(words.w) + at / 8u;
  std::memcpy(&low, bytes, sizeof low);
  std::memcpy(&high, bytes + (count < 64u ? 0u : 8u), sizeof high);
  bit = static_cast<uint>(high >> (count & 63u)) & 1u;
  return cvr_popcount(low & (count < 64u ? 0u : ~uint64_t{0})) +
         cvr_popcount(high & ((uint64_t{1} << (count & 63u)) - 1u));
#else
  uint last = (at + count) >> 5;
  uint ones = 0u;
  uint skipped = at & 31u;  // bits of the first word
  for (uint w = at >> 5; w < last; ++w) {
    ones += cvr_popcount32(cvr_read(words, w) >> skipped);
    skipped = 0u;
  }
  uint word = cvr_read(words, last);
  uint place = (at + count) & 31u;
  bit = (word >> place) & 1u;
  return ones + cvr_popcount32((word & ((1u << place) - 1u)) >> skipped);
#endif
}

// Which children of a coarse block are open.
CVR_FUNC uint cvr_c_mask(Words words, CsgvrcBrick brick, uint number) {
  return cvr_c_bits(
      words, brick.masks + 8u * number + CVR_C_COUNT_BITS * (number >> CVR_C_MASKS_SHIFT), 8u);
}

// The number of a child of a coarse block, among the open nodes of the brick. 0: the child is
// constant.
CVR_FUNC uint cvr_c_child(Words words, CsgvrcBrick brick, uint number, uint child) {
  uint record = number >> CVR_C_MASKS_SHIFT;
  uint at = brick.masks + record * CVR_C_MASKS_BITS;
  uint open;
  uint ones = cvr_c_ones(words, at, 8u * (number & (CVR_C_MASKS - 1u)) + child, open);
  if (open == 0u) return 0u;
  return 1u + ones +
         (record == 0u ? 0u : cvr_c_bits(words, at - CVR_C_COUNT_BITS, CVR_C_COUNT_BITS));
}

// Bit 3c of each child c with a label of its own.
CVR_FUNC uint cvr_c_own_labels(uint operations) {
  return (operations >> 2) & ~(operations >> 1) & ~operations & 0x249249u;
}

// The i-th of the 16-bit numbers from word `first` on.
CVR_FUNC uint cvr_c_short(Global tables, uint first, uint i) {
#ifdef __cplusplus
  return reinterpret_cast<const unsigned short*>(tables.w + first)[i];
#else
  return (cvr_read_global(tables, first + (i >> 1)) >> (16u * (i & 1u))) & 0xffffu;
#endif
}

// The operations of the block whose code begins at bit `at`, which moves behind it.
CVR_FUNC uint cvr_c_operations(Words words, Global tables, bool fine, CVR_INOUT(uint) at) {
  uint i = cvr_c_bits(words, at, CVR_C_CODE_BITS) + (fine ? CVR_C_LOOKUP : 0u);
  uint place = cvr_c_short(tables, CVR_C_PLACES, i);
  at += cvr_c_short(tables, 0u, i) & 63u;
  if (place == CVR_C_NO_PLACE) return cvr_c_bits(words, at - CVR_C_RAW_BITS, CVR_C_RAW_BITS);
  return cvr_read_global(tables, CVR_C_OPERATIONS + place);
}

// Moves over `blocks` codes from bit `at` on. Returns their labels.
CVR_FUNC uint cvr_c_skip(Words words, Global tables, bool fine, uint blocks, CVR_INOUT(uint) at) {
  uint first = fine ? CVR_C_LOOKUP : 0u;
  uint own_labels = 0u;
  uint64_t window = uint64_t(0u);
  int left = 0;  // bits of the window
  for (uint k = 0u; k < blocks; ++k) {
    if (left < int(CVR_C_CODE_BITS)) {
      window = cvr_word64(words, at >> 5) >> (at & 31u);
      left = 64 - int(at & 31u);
    }
    uint entry = cvr_c_short(tables, 0u, first + (uint(window) & (CVR_C_LOOKUP - 1u)));
    uint length = entry & 63u;
    window >>= length;
    left -= int(length);
    at += length;
    own_labels += entry >> 6;
  }
  return own_labels;
}

// One entry of an array whose index is no constant: a chain of choices where indexed registers are
// memory.
#ifdef __cplusplus
#define CVR_C_PICK(array, i) array[i]
#define CVR_C_PUT(array, i, value) array[i] = value
#else
#define CVR_C_PUT(array, i, value)                                                 \
  CVR_UNROLL for (uint place_ = 0u; place_ < CVR_C_PATH; ++place_) array[place_] = \
      place_ == (i) ? (value) : array[place_]
uint cvr_c_pick(uint array[CVR_C_PATH], uint i) {
  uint value = array[0];
  CVR_UNROLL for (uint place = 1u; place < CVR_C_PATH; ++place) value =
      place == i ? array[place] : value;
  return value;
}
#define CVR_C_PICK(array, i) cvr_c_pick(array, i)
#endif

// As cvr_csgvr_follow, without branches that depend on the operation; not at level 0.
CVR_FUNC bool cvr_c_follow(uint operation, CVR_INOUT(uint) n, CVR_INOUT(uint) level) {
  uint axis = (operation - (operation == CVR_OP_PARENT ? 0u : 1u)) & 3u;
  bool up = operation == CVR_OP_PARENT || ((n >> axis) & 1u) == 1u;
  n = up ? n >> 3 : n;
  level -= up ? 1u : 0u;
  uint mask = CVR_MORTON_X << axis;
  uint along = n & mask & ((1u << (3u * level)) - 1u);
  uint border = up ? mask & ((1u << (3u * level)) - 1u) : 0u;
  uint moved = (up ? (n | ~mask) + 1u : along - 1u) & mask;
  n = operation == CVR_OP_PARENT ? n : (n & ~mask) | moved;
  return operation == CVR_OP_PARENT || along != border;
}

// The level down to which the ways to (n, level) and (m, deeper), not above it, lead through the
// same blocks.
CVR_FUNC uint cvr_c_shared_level(uint n, uint level, uint m, uint deeper) {
  uint differs = (n ^ (m >> (3u * (deeper - level)))) >> 3;
  return differs == 0u ? level : level - (cvr_highest_bit(differs) / 3u + 1u);
}

// By choices, where indexed registers are memory.
CVR_FUNC CsgvrcRuns cvr_c_runs(CsgvrcBrick brick, bool fine) {
#ifdef __cplusplus
  return brick.runs[fine ? 1 : 0];
#else
  CsgvrcRuns runs = brick.runs[0];
  if (fine) runs = brick.runs[1];
  return runs;
#endif
}

// Reads the operation of child `child` of block `number`. If it is a label of the block's own,
// `index` is that label's.
CVR_FUNC uint cvr_c_operation(Words words, Global tables, CsgvrcBrick brick, bool fine, uint number,
                              uint child, CVR_INOUT(uint) index) {
  CsgvrcRuns runs = cvr_c_runs(brick, fine);
  uint k = fine ? number - brick.coarse_blocks : number;
  uint run = k >> CVR_C_RUN_SHIFT;
  uint at = cvr_c_run_begin(words, runs, run);
  uint labels = cvr_c_skip(words, tables, fine, k & (CVR_C_RUN - 1u), at);
  uint operations = cvr_c_operations(words, tables, fine, at);
  uint operation = (operations >> (3u * child)) & 7u;
  if (operation >= CVR_OP_ADVANCE) {
    labels += cvr_popcount32(cvr_c_own_labels(operations) & ((1u << (3u * child)) - 1u)) +
              (operation == CVR_OP_ADVANCE ? 1u : 0u);
    index = cvr_c_bits(words, cvr_c_run_end(words, runs, run) - labels * brick.index_bits,
                       brick.index_bits);
  }
  return operation;
}

// Dictionary index of a node's label. `hops` counts the operations read. False on a chain that no
// encoder writes.
CVR_FUNC bool cvr_c_index(Words words, Global tables, CsgvrcBrick brick, uint n, uint level,
                          CVR_OUT(uint) index, CVR_INOUT(uint) hops) {
  index = brick.root;
  if (brick.constant) return true;
  uint path[CVR_C_PATH];  // entry l - 1: the block with the ancestor at level l
  path[0] = 0u;
  uint known = 1u;  // levels of the path that are n's
  while (level > 0u) {
    while (known < level) {
      uint number = cvr_c_child(words, brick, CVR_C_PICK(path, known - 1u),
                                (n >> (3u * (level - known))) & 7u);
      if (number == 0u) {  // constant: the label is the ancestor's
        n >>= 3u * (level - known);
        level = known;
        break;
      }
      CVR_C_PUT(path, known, number);
      known += 1u;
    }
    hops += 1u;
    uint operation = cvr_c_operation(words, tables, brick, level + 1u == brick.levels,
                                     CVR_C_PICK(path, level - 1u), n & 7u, index);
    if (operation >= CVR_OP_ADVANCE) return index < brick.dictionary_size;
    uint m = n;
    uint deeper = level;
    if (!cvr_c_follow(operation, n, level)) return false;
    known = cvr_c_shared_level(n, level, m, deeper);
  }
  return true;
}

// The label at a dictionary index. The dictionary is never copied to shared memory.
CVR_FUNC uint cvr_c_label(Global words, CsgvrcBrick brick, uint index) {
  return cvr_c_bits_global(words, brick.dictionary + index * brick.label_bits, brick.label_bits);
}

#endif
