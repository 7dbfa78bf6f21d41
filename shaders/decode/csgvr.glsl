// `csgvr` and `csgvr-sb`: single nodes through the wavelet matrix, whole bricks in one sweep.
//
// Constant: CVR_CSGVR_STOP_BITS 0 or 1. Buffers: see bricks.glsl.
#include "shaders/decode/bricks.glsl"
#include "shaders/shared/csgvr.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/portable.glsl"

struct BrickCells {
  Global global;
  Words words;
  CsgvrBrick brick;
};

CVR_FUNC BrickCells cvr_open_cells(uvec3 brick, uint) {
  BrickCells cells;
  cells.global = cvr_brick_global(brick);
  cells.words = cvr_brick_words(cells.global);
  cells.brick = cvr_csgvr_open(cells.words, cvr_brick_word_count(brick), uint(CVR_LEVELS),
                               bool(CVR_CSGVR_STOP_BITS));
  return cells;
}

CVR_FUNC uint cvr_decode_cell(BrickCells cells, uvec3 cell, uint lod) {
  uint level = uint(CVR_BRICK_SHIFT) - lod;
  uvec3 node = cell & ((1u << level) - 1u);
  uint index;
  uint hops = 0u;
  if (!cvr_csgvr_palette_index(cells.words, cells.brick, cvr_morton_encode(node.x, node.y, node.z),
                               level, index, hops))
    index = 0u;
  CVR_COUNT_HOPS(hops);
  return cvr_csgvr_label(cells.global, cells.brick, index);
}

// Whether all voxels of the cell's 2x2x2 block (of level 0 or 1) have its label: a node above the
// cell has a stop bit. Never without stop bits.
#define CVR_KNOWS_UNIFORM_BLOCKS 1
CVR_FUNC bool cvr_block_is_uniform(BrickCells cells, uvec3 cell, uint lod) {
  uint level = uint(CVR_BRICK_SHIFT) - lod;
  uvec3 inside = cell & ((1u << level) - 1u);
  uint node = cvr_morton_encode(inside.x, inside.y, inside.z);
  uint stopped = level;
  cvr_csgvr_index(cells.words, cells.brick, node, stopped);
  return stopped < level;
}

#ifndef CVR_WITHOUT_SERIAL
#define CVR_SERIAL_WAVELET
#define CVR_SERIAL_STOP_BITS CVR_CSGVR_STOP_BITS
#define CVR_SERIAL_DELTA 0
#include "shaders/decode/serial.glsl"
#endif
