// Which bricks hold a visible label: one invocation for each part of a brick, as many parts as its
// edge has voxels, before the first frame of a scene. The words of cvr_frame.bricks are zero
// before.
layout(local_size_x = 64) in;

void main() {
  uint parts = 1u << CVR_BRICK_SHIFT;
  uint count = cvr_frame.grid[0] * cvr_frame.grid[1] * cvr_frame.grid[2];
  for (uint i = gl_GlobalInvocationID.x; i / parts < count;
       i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    if (cvr_decode_visible(cvr_brick_at(i / parts), i % parts))
      atomicOr(Words32(cvr_frame.bricks).w[i / parts], 1u);
  }
}
