// What the decoder texts of the CSGV families share: where a brick lies, its palette, its root.
//
// Buffers: 0 starts   first word of each brick and the end, bricks x fastest
//          1 bricks   [CVR_LEVELS words][palette size] ... [palette, reversed]
// The first palette entry, the last word of a brick, is the label of its root; every label of the
// brick is in its palette.
#include "shaders/shared/portable.glsl"

CVR_FUNC uint cvr_brick_index(uvec3 brick) {
  uvec3 grid = cvr_grid();
  return brick.x + grid.x * (brick.y + grid.y * brick.z);
}

CVR_FUNC Global cvr_brick_global(uvec3 brick) {
  return CVR_BUFFER_AT(1, uint64_t(cvr_read_global(CVR_BUFFER(0), cvr_brick_index(brick))));
}

CVR_FUNC uint cvr_brick_word_count(uvec3 brick) {
  Global starts = CVR_BUFFER(0);
  uint i = cvr_brick_index(brick);
  return cvr_read_global(starts, i + 1u) - cvr_read_global(starts, i);
}

CVR_FUNC Words cvr_brick_words(Global global) {
#ifdef CVR_WORDS_SHARED
  return Words(0u);
#else
  return global;
#endif
}

CVR_FUNC uint cvr_brick_palette_size(Global words) {
  return cvr_read_global(words, uint(CVR_LEVELS));
}

CVR_FUNC uint cvr_decode_root(uvec3 brick) {
  return cvr_read_global(cvr_brick_global(brick), cvr_brick_word_count(brick) - 1u);
}

CVR_FUNC bool cvr_decode_visible(uvec3 brick, uint part) {
  Global words = cvr_brick_global(brick);
  uint end = cvr_brick_word_count(brick);
  for (uint i = end - cvr_brick_palette_size(words) + part; i < end;
       i += 1u << uint(CVR_BRICK_SHIFT)) {
    if (cvr_code_visible(cvr_read_global(words, i))) return true;
  }
  return false;
}

// Everything but the palette.
CVR_FUNC uint cvr_shared_words(uvec3 brick) {
  return cvr_brick_word_count(brick) - cvr_brick_palette_size(cvr_brick_global(brick));
}

CVR_FUNC Global cvr_shared_source(uvec3 brick) { return cvr_brick_global(brick); }
