// Access through the brick cache. A brick that is not held at the wanted level is asked for, for
// the next frame; until then the level that is held stands in, or the brick's coarsest label.
#include "shaders/caches/brick_state.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/portable.glsl"

#define CVR_LOOKUP_LOOPS 0u

bool cvr_complete = true;

uint cvr_held;      // level held of the current brick
Labels cvr_labels;  // its codes
uint cvr_root;      // code of the coarsest level

void cvr_enter_brick(uvec3, uint index, uint lod) {
  cvr_root = CVR_ROOTS.w[index];
  if (lod == CVR_LEVELS - 1u) {
    cvr_held = CVR_NO_LEVEL;
    return;
  }
  Words32 state = Words32(cvr_frame.cache[1]);
  state.w[cvr_wish_address(index)] = cvr_frame.frame << 8 | lod;
  cvr_held = state.w[cvr_level_address(index)];
  if (cvr_held != CVR_NO_LEVEL) cvr_labels = cvr_region(state.w[cvr_unit_address(index)]);
  if (cvr_held != lod) {
    cvr_complete = false;
    CVR_COUNT(CVR_COUNT_CACHE_MISSES, 1);
  } else {
    CVR_COUNT(CVR_COUNT_CACHE_HITS, 1);
  }
}

bool cvr_lookup(uvec3 cell, uint lod, uvec3 brick, out uint code, out bool invisible) {
  invisible = false;
  code = cvr_root;
  if (cvr_held == CVR_NO_LEVEL) {
    if (lod != CVR_LEVELS - 1u) CVR_COUNT(CVR_COUNT_PLACEHOLDER_CELLS, 1);
    return true;
  }
  uvec3 held = cvr_held == lod ? cell : (cell << lod) >> cvr_held;
  uvec3 inside = held & ((1u << (CVR_BRICK_SHIFT - cvr_held)) - 1u);
  code = cvr_load(cvr_labels, cvr_morton_encode(inside.x, inside.y, inside.z));
  return true;
}
