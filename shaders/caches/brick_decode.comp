// Third pass: decodes the listed bricks into their regions.
//   CVR_DECODE_SERIAL       one invocation a brick, by the codec's serial decoder or, where it has none, cell by cell
//   else                    one subgroup (= workgroup) a brick, by the codec's decoder for subgroups or, where it has none, each invocation
//                           every n-th cell; with CVR_WORDS_SHARED it copies what is read over and
//                           over to shared memory first
// Where a driver bounds loops, a brick is decoded in parts by several dispatches: cells cvr_push.x
// to cvr_push.x + cvr_push.y.
#include "shaders/caches/brick_state.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/portable.glsl"

layout(local_size_x = CVR_DECODE_WIDTH) in;

#if (defined(CVR_DECODE_SERIAL) && !defined(CVR_HAS_SERIAL)) || \
    (!defined(CVR_DECODE_SERIAL) && !defined(CVR_HAS_TOGETHER))
void cvr_decode_cells(uvec3 brick, uint lod, Labels labels, uint first, uint stride) {
  uint shift = CVR_BRICK_SHIFT - lod;
  uvec3 cells = (cvr_extent() + ((1u << lod) - 1u)) >> lod;
  uint end = min(1u << (3u * shift), cvr_push.x + cvr_push.y);
  BrickCells opened = cvr_open_cells(brick, lod);
  for (uint n = cvr_push.x + first; n < end; n += stride) {
    uvec3 cell = (brick << shift) +
                 uvec3(cvr_morton_gather(n), cvr_morton_gather(n >> 1), cvr_morton_gather(n >> 2));
    if (all(lessThan(cell, cells))) cvr_store(labels, n, cvr_decode_cell(opened, cell, lod));
  }
}
#endif

void cvr_count_brick(uint lod) {
#ifdef CVR_INSTRUMENTED
  if (cvr_push.x > 0u) return;
  CVR_COUNT(CVR_COUNT_BRICKS_DECODED, 1);
  CVR_COUNT(CVR_COUNT_CELLS_DECODED, 1u << (3u * (CVR_BRICK_SHIFT - lod)));
#endif
}

void main() {
  Words32 state = Words32(cvr_frame.cache[1]);
  uint count = CVR_CONTROL.w[CVR_CONTROL_DECODE];
#ifdef CVR_DECODE_SERIAL
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * CVR_DECODE_WIDTH) {
    uint index = Words32(cvr_frame.cache[4]).w[i];
    Labels labels = cvr_region(state.w[cvr_unit_address(index)]);
    uint lod = state.w[cvr_level_address(index)];
    cvr_count_brick(lod);
#ifdef CVR_HAS_SERIAL
    cvr_decode_brick(cvr_brick_at(index), lod, labels);
#else
    cvr_decode_cells(cvr_brick_at(index), lod, labels, 0u, 1u);
#endif
  }
#else
  for (uint i = gl_WorkGroupID.x; i < count; i += gl_NumWorkGroups.x) {
    uint index = Words32(cvr_frame.cache[4]).w[i];
    uvec3 brick = cvr_brick_at(index);
    uint lod = state.w[cvr_level_address(index)];
    if (gl_LocalInvocationID.x == 0u) cvr_count_brick(lod);
#ifdef CVR_WORDS_SHARED
    barrier();
    Global source = cvr_shared_source(brick);
    uint words = cvr_shared_words(brick);
    for (uint w = gl_LocalInvocationID.x; w < words; w += CVR_DECODE_WIDTH)
      cvr_shared[w] = cvr_read_global(source, w);
    barrier();
#endif
    Labels labels = cvr_region(state.w[cvr_unit_address(index)]);
#ifdef CVR_HAS_TOGETHER
    cvr_decode_brick_together(brick, lod, labels);
#else
    cvr_decode_cells(brick, lod, labels, gl_LocalInvocationID.x, CVR_DECODE_WIDTH);
#endif
  }
#endif
  cvr_keep_counts();
}
