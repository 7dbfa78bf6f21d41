// `csgv-ctx`: whole bricks in one sweep; no access to single nodes.
//
// Buffers: see groups.glsl; 2 labels   of the volume, ascending
//                           3 tables   see CtxTables
// Constants: CVR_CTX_GROUP_SHIFT log2 of the bricks per side of a group; CVR_CTX_LABEL_BITS;
// CVR_CTX_ROWS_AT, CVR_CTX_SLOTS_AT, CVR_CTX_SYMBOLS_AT, CVR_CTX_NUMBERS: see CtxTables.
#include "shaders/decode/groups.glsl"
#include "shaders/shared/brick_limits.glsl"
#include "shaders/shared/csgv_ctx.glsl"
#include "shaders/shared/portable.glsl"

struct CtxPlace {
  Global words;  // of the group
  CtxGroup group;
  uint member;
};

CVR_FUNC CtxPlace cvr_ctx_place(uvec3 brick) {
  uint shift = uint(CVR_CTX_GROUP_SHIFT);
  uvec3 bricks = cvr_group_bricks(brick, shift);
  CtxPlace place;
  place.words = CVR_BUFFER_AT(1, cvr_group_word(brick, shift));
  place.group =
      cvr_ctx_group(place.words, bricks.x * bricks.y * bricks.z, uint(CVR_CTX_LABEL_BITS));
  place.member = cvr_group_member(brick, shift);
  return place;
}

CVR_FUNC CtxDecoding cvr_ctx_decoding(CtxPlace place, uvec3 brick, uint lod) {
  uvec3 extent = cvr_extent();
  CtxDecoding decoding;
  decoding.group = place.group;
  decoding.brick = cvr_ctx_brick(place.words, place.group, place.member);
  decoding.tables.rows_at = uint(CVR_CTX_ROWS_AT);
  decoding.tables.slots_at = uint(CVR_CTX_SLOTS_AT);
  decoding.tables.symbols_at = uint(CVR_CTX_SYMBOLS_AT);
  decoding.tables.numbers = uint(CVR_CTX_NUMBERS);
  decoding.tables.label_bits = uint(CVR_CTX_LABEL_BITS);
  decoding.levels = uint(CVR_LEVELS);
  decoding.target = uint(CVR_BRICK_SHIFT) - lod;
  decoding.valid_x = cvr_brick_valid(brick.x, extent.x, uint(CVR_BRICK_SHIFT));
  decoding.valid_y = cvr_brick_valid(brick.y, extent.y, uint(CVR_BRICK_SHIFT));
  decoding.valid_z = cvr_brick_valid(brick.z, extent.z, uint(CVR_BRICK_SHIFT));
  return decoding;
}

CVR_FUNC uint cvr_decode_root(uvec3 brick) {
  CtxPlace place = cvr_ctx_place(brick);
  uint bits = uint(CVR_CTX_LABEL_BITS);
  return cvr_ctx_list_label(place.words, CVR_BUFFER(2), place.group,
                            cvr_ctx_root(place.words, place.group, place.member), bits);
}

CVR_FUNC bool cvr_decode_visible(uvec3 brick, uint part) {
  CtxPlace place = cvr_ctx_place(brick);
  CtxDecoding decoding = cvr_ctx_decoding(place, brick, 0u);
  for (uint i = part; i < decoding.brick.labels; i += 1u << uint(CVR_BRICK_SHIFT)) {
    if (cvr_code_visible(cvr_ctx_label(place.words, CVR_BUFFER(2), decoding, i))) return true;
  }
  return false;
}

CVR_FUNC void cvr_decode_brick(uvec3 brick, uint lod, Labels labels) {
  CtxPlace place = cvr_ctx_place(brick);
  cvr_ctx_decode(place.words, CVR_BUFFER(2), CVR_BUFFER(3), cvr_ctx_decoding(place, brick, lod),
                 labels);
}

#ifdef CVR_HAS_TOGETHER
#include "shaders/decode/csgv_ctx_together.glsl"
#endif
