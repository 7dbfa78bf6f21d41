// `csgvr-nibble`: single nodes by counting nibbles, whole bricks in one sweep. Buffers: see
// bricks.glsl.
#include "shaders/decode/bricks.glsl"
#include "shaders/shared/csgvr_nibble.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/portable.glsl"

struct BrickCells {
  Global global;
  Words words;
  uint word_count;
};

CVR_FUNC BrickCells cvr_open_cells(uvec3 brick, uint) {
  BrickCells cells;
  cells.global = cvr_brick_global(brick);
  cells.words = cvr_brick_words(cells.global);
  cells.word_count = cvr_brick_word_count(brick);
  return cells;
}

CVR_FUNC uint cvr_decode_cell(BrickCells cells, uvec3 cell, uint lod) {
  uint level = uint(CVR_BRICK_SHIFT) - lod;
  uvec3 node = cell & ((1u << level) - 1u);
  uint n = cvr_morton_encode(node.x, node.y, node.z);
  uint index;
  uint hops = 0u;
  if (!cvr_csgvr_nibble_palette_index(cells.words, uint(CVR_LEVELS), n, level, index, hops))
    index = 0u;
  CVR_COUNT_HOPS(hops);
  return cvr_read_global(cells.global, cells.word_count - 1u - index);
}

#ifndef CVR_WITHOUT_SERIAL
#define CVR_SERIAL_CSGVR_NIBBLE
#define CVR_SERIAL_STOP_BITS 0
#define CVR_SERIAL_DELTA 0
#include "shaders/decode/serial.glsl"
#endif
