// Voxel cache, without and with empty-space bits (CVR_EMPTY_SPACE; CSGV-R paper, section 4.2 and Algorithm 4).
//
// Departure from Algorithm 4, which would draw wrong pixels at coarse levels: it looks up the finest 2x2x2 block whatever the level,
// but a coarse node can be visible though a block below it is not. Here a bit stands for a 2x2x2 block at levels 0 and 1, and
// for the node itself at coarser levels: the bits of level l >= 2 follow those of the blocks.
// cache[1] the bits; cache_sizes[2..7]: first word of the bits of levels 1 (also level 0), 2, 3, ...
#include "shaders/caches/cuckoo_table.glsl"

bool cvr_complete = true;

void cvr_enter_brick(uvec3 brick, uint index, uint lod) {}

#ifdef CVR_EMPTY_SPACE
struct EmptyBit {
  uint word;
  uint mask;
};

EmptyBit cvr_empty_bit(uvec3 cell, uint lod) {
  uint level = max(lod, 1u);
  uvec3 block = cell >> (level - lod);
  uvec3 blocks = (cvr_extent() + ((1u << level) - 1u)) >> level;
  uint64_t bit = uint64_t(block.x) + uint64_t(blocks.x) * (uint64_t(block.y) + uint64_t(blocks.y) * uint64_t(block.z));
  return EmptyBit(cvr_frame.cache_sizes[1u + level] + uint(bit >> 5), 1u << (uint(bit) & 31u));
}

// Whether no finest voxel of the 2x2x2 block of `cell` is visible; `cell` is known not to be.
bool cvr_block_invisible(uvec3 cell, uint lod) {
  if (lod >= 2u) return true;
  uvec3 origin = (cell >> (1u - lod)) << 1u;
  for (uint c = 0u; c < 8u; ++c) {
    uvec3 voxel = origin + uvec3(c & 1u, c >> 1 & 1u, c >> 2);
    if (any(greaterThanEqual(voxel, cvr_extent())) || (lod == 0u && voxel == cell)) continue;
    CVR_COUNT(CVR_COUNT_CELLS_DECODED, 1);
    if (cvr_code_visible(cvr_decode_cell(voxel, 0u))) return false;
  }
  return true;
}
#endif

uint cvr_access(uvec3 cell, uint lod, uvec3 brick, out bool invisible) {
  invisible = false;
#ifdef CVR_EMPTY_SPACE
  EmptyBit bit = cvr_empty_bit(cell, lod);
  if ((Words32(cvr_frame.cache[1]).w[bit.word] & bit.mask) != 0u) {
    CVR_COUNT(CVR_COUNT_EMPTY_SPACE_SKIPS, 1);
    invisible = true;
    return 0u;
  }
#endif
  CuckooSlot slot;
  uint code;
  if (cvr_cuckoo_find(cell << lod, lod, slot, code)) {
    CVR_COUNT(CVR_COUNT_CACHE_HITS, 1);
#ifdef CVR_INSTRUMENTED
    if (cvr_decode_cell(cell, lod) != code) CVR_COUNT(CVR_COUNT_WRONG_LABELS, 1);
#endif
    return code;
  }
  CVR_COUNT(CVR_COUNT_CACHE_MISSES, 1);
  CVR_COUNT(CVR_COUNT_CELLS_DECODED, 1);
  code = cvr_decode_cell(cell, lod);
#ifdef CVR_EMPTY_SPACE
  if (!cvr_code_visible(code) && cvr_block_invisible(cell, lod)) {
    CVR_COUNT(CVR_COUNT_EMPTY_SPACE_MARKS, 1);
    atomicOr(Words32(cvr_frame.cache[1]).w[bit.word], bit.mask);
    invisible = true;
    return 0u;
  }
#endif
  cvr_cuckoo_insert(slot, code);
  return code;
}
