// Before the first frame: the code of each brick's coarsest node, which stands in for a brick that
// is not held. One invocation a brick.
#include "shaders/caches/brick_state.glsl"

layout(local_size_x = 64) in;

void main() {
  uint bricks = cvr_frame.cache_sizes[1];
  for (uint brick = gl_GlobalInvocationID.x; brick < bricks;
       brick += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    CVR_ROOTS.w[brick] = cvr_decode_root(cvr_brick_at(brick));
  }
}
