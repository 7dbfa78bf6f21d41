// Decodes all cells of a level, for checking: code of each cell to cvr_frame.labels, u32 each.
//   default              one invocation a cell, x fastest over the level
//   CVR_PROBE_BRICKS     one invocation a brick, the codec's serial decoder; each brick has 8^(L-1-lod) codes in Morton order
//   CVR_WORDS_SHARED     one workgroup a brick from a copy in shared memory, cells cvr_push.y to cvr_push.y + cvr_push.z; same order
// cvr_push.x: the level.
#include "shaders/shared/morton.glsl"
#include "shaders/shared/portable.glsl"

layout(local_size_x = CVR_PROBE_WIDTH) in;

void main() {
  uint lod = cvr_push.x;
  uint shift = CVR_BRICK_SHIFT - lod;
  uvec3 cells = (cvr_extent() + ((1u << lod) - 1u)) >> lod;
#if defined(CVR_PROBE_BRICKS)
  uint index = gl_GlobalInvocationID.x;
  if (index >= cvr_frame.grid[0] * cvr_frame.grid[1] * cvr_frame.grid[2]) return;
  cvr_decode_brick(cvr_brick_at(index), lod,
                   Labels(cvr_frame.labels + (uint64_t(index) << (3u * shift + 2u))));
#elif defined(CVR_WORDS_SHARED)
  uint index = gl_WorkGroupID.x;
  uvec3 brick = cvr_brick_at(index);
  Global source = cvr_shared_source(brick);
  uint words = cvr_shared_words(brick);
  for (uint w = gl_LocalInvocationID.x; w < words; w += CVR_PROBE_WIDTH)
    cvr_shared[w] = cvr_read_global(source, w);
  barrier();
  Labels labels = Labels(cvr_frame.labels + (uint64_t(index) << (3u * shift + 2u)));
  uint end = min(1u << (3u * shift), cvr_push.y + cvr_push.z);
  BrickCells opened = cvr_open_cells(brick, lod);
  for (uint n = cvr_push.y + gl_LocalInvocationID.x; n < end; n += CVR_PROBE_WIDTH) {
    uvec3 cell = (brick << shift) +
                 uvec3(cvr_morton_gather(n), cvr_morton_gather(n >> 1), cvr_morton_gather(n >> 2));
    if (all(lessThan(cell, cells))) cvr_store(labels, n, cvr_decode_cell(opened, cell, lod));
  }
#else
  uint index = gl_GlobalInvocationID.x;
  if (index >= cells.x * cells.y * cells.z) return;
  uint row = index / cells.x;
  uvec3 cell = uvec3(index - row * cells.x, row % cells.y, row / cells.y);
  cvr_store(Labels(cvr_frame.labels), index,
            cvr_decode_cell(cvr_open_cells(cell >> shift, lod), cell, lod));
#endif
}
