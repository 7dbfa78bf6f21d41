// Which bricks hold a visible label: one invocation a brick, before the first frame of a scene. cvr_push.xy: address of one u32 a brick.
layout(local_size_x = 8) in;

void main() {
  uint count = cvr_frame.grid[0] * cvr_frame.grid[1] * cvr_frame.grid[2];
  uint64_t address = uint64_t(cvr_push.x) | uint64_t(cvr_push.y) << 32;
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    Words32(address).w[i] = cvr_decode_visible(cvr_brick_at(i)) ? 1u : 0u;
  }
}
