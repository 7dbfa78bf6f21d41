// Voxel cache, without and with empty-space bits (CVR_EMPTY_SPACE; CSGV-R paper, section 4.2 and
// Algorithm 4).
//
// Departure from Algorithm 4, which would draw wrong pixels at coarse levels: it looks up the
// finest 2x2x2 block whatever the level, but a coarse node can be visible though a block below it
// is not. Here a bit stands for a 2x2x2 block at levels 0 and 1, and for the node itself at coarser
// levels: the bits of level l >= 2 follow those of the blocks. cache[1] the bits;
// cache_sizes[2..7]: first word of the bits of levels 1 (also level 0), 2, 3, ...
//
// With CVR_EMPTY_BLOCK_SHIFT it is Algorithm 4 to the letter: a bit for each block of that edge
// (log2), whatever the level, and all voxels of the block are decoded, the cell's own too.
#include "shaders/caches/cuckoo_table.glsl"

#define CVR_LOOKUP_LOOPS 0u
#if defined(CVR_EMPTY_BLOCK_SHIFT)
#define CVR_RESOLVE_LOOPS (((1u << 3u * CVR_EMPTY_BLOCK_SHIFT) + 1u) * (CVR_CELL_LOOPS + 1u))
#elif defined(CVR_EMPTY_SPACE)
#define CVR_RESOLVE_LOOPS (9u * (CVR_CELL_LOOPS + 1u))
#else
#define CVR_RESOLVE_LOOPS CVR_CELL_LOOPS
#endif

bool cvr_complete = true;

void cvr_enter_brick(uvec3 brick, uint index, uint lod) {}

#ifdef CVR_EMPTY_SPACE
struct EmptyBit {
  uint word;
  uint mask;
};

EmptyBit cvr_empty_bit(uvec3 cell, uint lod) {
#ifdef CVR_EMPTY_BLOCK_SHIFT
  const uint level = CVR_EMPTY_BLOCK_SHIFT;
  uvec3 block = cell << lod >> level;
  const uint first = 0u;
#else
  uint level = max(lod, 1u);
  uvec3 block = cell >> (level - lod);
  uint first = cvr_frame.cache_sizes[1u + level];
#endif
  uvec3 blocks = (cvr_extent() + ((1u << level) - 1u)) >> level;
  uint64_t bit = uint64_t(block.x) +
                 uint64_t(blocks.x) * (uint64_t(block.y) + uint64_t(blocks.y) * uint64_t(block.z));
  return EmptyBit(first + uint(bit >> 5), 1u << (uint(bit) & 31u));
}

#endif

// True if the table or the empty-space bits know the cell.
bool cvr_lookup(uvec3 cell, uint lod, uvec3 brick, out uint code, out bool invisible) {
  invisible = false;
  code = 0u;
#ifdef CVR_EMPTY_SPACE
  EmptyBit bit = cvr_empty_bit(cell, lod);
  if ((Words32(cvr_frame.cache[1]).w[bit.word] & bit.mask) != 0u) {
    CVR_COUNT(CVR_COUNT_EMPTY_SPACE_SKIPS, 1);
    invisible = true;
    return true;
  }
#endif
  CuckooSlot slot;
  if (!cvr_cuckoo_find(cell << lod, lod, slot, code)) return false;
  CVR_COUNT(CVR_COUNT_CACHE_HITS, 1);
#ifdef CVR_INSTRUMENTED
  cvr_checking = true;
  if (cvr_decode_cell(cvr_open_cells(brick, lod), cell, lod) != code)
    CVR_COUNT(CVR_COUNT_WRONG_LABELS, 1);
  cvr_checking = false;
#endif
  return true;
}

// Decodes a cell that cvr_lookup does not know, and keeps it. With empty-space bits, an invisible
// cell makes the voxels of its block be decoded too, until one is visible, unless the decoder knows
// that they all have the cell's label; the loop has the only call of the decoder, since a kernel
// carries each call's text.
uint cvr_resolve(uvec3 cell, uint lod, uvec3 brick, out bool invisible) {
  CVR_COUNT(CVR_COUNT_CACHE_MISSES, 1);
  invisible = false;
#if defined(CVR_EMPTY_BLOCK_SHIFT)
  uint code = 0u;
  BrickCells cells;
  uvec3 corner = cell << lod >> CVR_EMPTY_BLOCK_SHIFT << CVR_EMPTY_BLOCK_SHIFT;
  const uint in_edge = (1u << CVR_EMPTY_BLOCK_SHIFT) - 1u;
  for (uint c = 0u; c <= 1u << 3u * CVR_EMPTY_BLOCK_SHIFT; ++c) {
    uint i = c - 1u;
    uvec3 at = c == 0u ? cell
                       : corner + uvec3(i & in_edge, i >> CVR_EMPTY_BLOCK_SHIFT & in_edge,
                                        i >> 2u * CVR_EMPTY_BLOCK_SHIFT);
    if (any(greaterThanEqual(at, cvr_extent()))) continue;
    CVR_COUNT(CVR_COUNT_CELLS_DECODED, 1);
    uint level = c == 0u ? lod : 0u;
    if (c <= 1u) cells = cvr_open_cells(brick, level);
    uint found = cvr_decode_cell(cells, at, level);
    bool visible = cvr_code_visible(found);
    if (c == 0u) {
      code = found;
      if (visible) break;
      invisible = true;
    } else if (visible) {
      invisible = false;
    }
  }
  if (invisible) {
    CVR_COUNT(CVR_COUNT_EMPTY_SPACE_MARKS, 1);
    EmptyBit bit = cvr_empty_bit(cell, lod);
    atomicOr(Words32(cvr_frame.cache[1]).w[bit.word], bit.mask);
    return 0u;
  }
#elif defined(CVR_EMPTY_SPACE)
  uint code = 0u;
  BrickCells cells;
  uint voxels = lod < 2u ? 8u : 0u;  // of the block, besides the cell
  for (uint c = 0u; c <= voxels; ++c) {
    uvec3 block = (lod < 2u ? cell >> (1u - lod) : cell) << 1u;
    uvec3 at = c == 0u ? cell : block + uvec3(c - 1u & 1u, c - 1u >> 1 & 1u, c - 1u >> 2);
    if (c > 0u && (any(greaterThanEqual(at, cvr_extent())) || (lod == 0u && at == cell))) continue;
    CVR_COUNT(CVR_COUNT_CELLS_DECODED, 1);
    uint level = c == 0u ? lod : 0u;
    if (c == 0u || (c == 1u && lod > 0u)) cells = cvr_open_cells(brick, level);
    uint found = cvr_decode_cell(cells, at, level);
    if (c == 0u) code = found;
    invisible = !cvr_code_visible(found);
    if (!invisible) break;
#ifdef CVR_KNOWS_UNIFORM_BLOCKS
    if (c == 0u && voxels > 0u && cvr_block_is_uniform(cells, cell, lod)) break;
#endif
  }
  if (invisible) {
    CVR_COUNT(CVR_COUNT_EMPTY_SPACE_MARKS, 1);
    EmptyBit bit = cvr_empty_bit(cell, lod);
    atomicOr(Words32(cvr_frame.cache[1]).w[bit.word], bit.mask);
    return 0u;
  }
#else
  CVR_COUNT(CVR_COUNT_CELLS_DECODED, 1);
  uint code = cvr_decode_cell(cvr_open_cells(brick, lod), cell, lod);
#endif
  CuckooSlot slot;
  uint other;
  cvr_cuckoo_find(cell << lod, lod, slot, other);
  cvr_cuckoo_insert(slot, code);
  return code;
}
