// First pass of a frame: compares what the last frame wanted with what is held. One invocation a
// brick. cvr_push.x: 1 = also give up bricks that the last frame did not want (there was no room);
// 2 = give up everything (no room, but in pieces); the host then has emptied stacks and control
// block.
#include "shaders/caches/brick_state.glsl"

layout(local_size_x = 64) in;

void main() {
  uint brick = gl_GlobalInvocationID.x;
  uint bricks = cvr_frame.cache_sizes[1];
  if (brick >= bricks) return;
  Words32 state = Words32(cvr_frame.cache[1]);
  uint wish = state.w[cvr_wish_address(brick)];
  bool wanted = wish >> 8 == cvr_push.y;
  uint level = wish & 255u;
  uint held = state.w[cvr_level_address(brick)];
  if (cvr_push.x == 2u) held = CVR_NO_LEVEL;
  bool request = wanted && held != level;
  bool release = held != CVR_NO_LEVEL && (request || (cvr_push.x == 1u && !wanted));
  if (release) {
    uint at = atomicAdd(CVR_CONTROL.w[CVR_CONTROL_FREE + held], 1u);
    Words32(cvr_frame.cache[3]).w[held * bricks + at] = state.w[cvr_unit_address(brick)];
    held = CVR_NO_LEVEL;
  }
  if (request) {
    held = CVR_WANTED | level;
    atomicAdd(CVR_CONTROL.w[CVR_CONTROL_REQUESTED], 1u);
  }
  state.w[cvr_level_address(brick)] = held;
}
