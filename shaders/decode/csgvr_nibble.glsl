// `csgvr-nibble`: single nodes by counting nibbles, whole bricks in one sweep. Buffers: see bricks.glsl.
#include "shaders/decode/bricks.glsl"

CVR_FUNC uint cvr_decode_cell(uvec3 cell, uint lod) {
  uint level = uint(CVR_BRICK_SHIFT) - lod;
  uvec3 brick = cell >> level;
  uvec3 node = cell & ((1u << level) - 1u);
  uint index;
  uint hops = 0u;
  if (!cvr_csgvr_nibble_palette_index(cvr_brick_words(brick), uint(CVR_LEVELS), cvr_morton_encode(node.x, node.y, node.z), level,
                                      index, hops)) {
    index = 0u;
  }
  CVR_COUNT_HOPS(hops);
  return cvr_read_global(cvr_brick_global(brick), cvr_brick_word_count(brick) - 1u - index);
}

#ifndef CVR_WITHOUT_SERIAL
#define CVR_SERIAL_CSGVR_NIBBLE
#define CVR_SERIAL_STOP_BITS 0
#define CVR_SERIAL_DELTA 0
#include "shaders/decode/serial.glsl"
#endif
