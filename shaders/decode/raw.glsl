// `raw`: voxels as they are, with the levels of the label pyramid beside them.
//
// Buffers: 0 voxels   all levels, each from a whole word on
//          1 levels   5 words per level: first word (low, high), extent along x, y, z
//          2 remap    only where CVR_REMAP_SIZE > 0: all labels, ascending, two words each
// Constants: CVR_RAW_BITS 8, 16, 32 or 64 bits per voxel; CVR_REMAP_SIZE labels that do not fit in 32
// bits (with 64 bits alone)
#include "shaders/shared/label_codes.glsl"
#include "shaders/shared/portable.glsl"

struct BrickCells {
  uint64_t first;  // word of the level
  uint64_t extent_x, extent_y;
};

CVR_FUNC BrickCells cvr_open_cells(uvec3, uint lod) {
  Global levels = CVR_BUFFER(1);
  uint at = 5u * lod;
  BrickCells cells;
  cells.first = cvr_word64_global(levels, at);
  cells.extent_x = uint64_t(cvr_read_global(levels, at + 2u));
  cells.extent_y = uint64_t(cvr_read_global(levels, at + 3u));
  return cells;
}

CVR_FUNC uint cvr_decode_cell(BrickCells cells, uvec3 cell, uint) {
  uint64_t voxel =
      uint64_t(cell.x) + cells.extent_x * (uint64_t(cell.y) + cells.extent_y * uint64_t(cell.z));
  uint64_t bit = voxel * uint64_t(CVR_RAW_BITS);
  Global words = CVR_BUFFER_AT(0, cells.first + (bit >> 5));
  CVR_COUNT_HOPS(1u);
#if CVR_RAW_BITS == 64
  return cvr_code_of(CVR_BUFFER(2), uint(CVR_REMAP_SIZE), cvr_word64_global(words, 0u));
#elif CVR_RAW_BITS == 32
  return cvr_read_global(words, 0u);
#else
  return (cvr_read_global(words, 0u) >> (uint(bit) & 31u)) & ((1u << uint(CVR_RAW_BITS)) - 1u);
#endif
}

#include "shaders/decode/voxels.glsl"
