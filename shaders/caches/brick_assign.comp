// Second pass: gives each requested brick a region, from its level's stack or from the untouched end, and lists it for decoding.
// cvr_push.x: invocations of a decoding workgroup that take a brick each; cvr_push.y: most workgroups of a dispatch.
#include "shaders/caches/brick_state.glsl"

layout(local_size_x = 64) in;

bool cvr_allocate(uint lod, out uint unit) {
  uint available = CVR_CONTROL.w[CVR_CONTROL_FREE + lod];
  while (available > 0u) {
    uint before = atomicCompSwap(CVR_CONTROL.w[CVR_CONTROL_FREE + lod], available, available - 1u);
    if (before == available) {
      unit = Words32(cvr_frame.cache[3]).w[lod * cvr_frame.cache_sizes[1] + available - 1u];
      return true;
    }
    available = before;
  }
  uint units = cvr_units_of(lod);
  uint bump = CVR_CONTROL.w[CVR_CONTROL_BUMP];
  while (units <= cvr_frame.cache_sizes[0] && bump <= cvr_frame.cache_sizes[0] - units) {
    uint before = atomicCompSwap(CVR_CONTROL.w[CVR_CONTROL_BUMP], bump, bump + units);
    if (before == bump) {
      unit = bump;
      return true;
    }
    bump = before;
  }
  return false;
}

void main() {
  uint brick = gl_GlobalInvocationID.x;
  if (brick >= cvr_frame.cache_sizes[1]) return;
  Words32 state = Words32(cvr_frame.cache[1]);
  uint level = state.w[cvr_level_address(brick)];
  if (level == CVR_NO_LEVEL || (level & CVR_WANTED) == 0u) return;
  level &= ~CVR_WANTED;
  uint unit = 0u;
  if (!cvr_allocate(level, unit)) {
    state.w[cvr_level_address(brick)] = CVR_NO_LEVEL;
    atomicAdd(CVR_CONTROL.w[CVR_CONTROL_REFUSED], 1u);
    return;
  }
  state.w[cvr_level_address(brick)] = level;
  state.w[cvr_unit_address(brick)] = unit;
  uint at = atomicAdd(CVR_CONTROL.w[CVR_CONTROL_DECODE], 1u);
  Words32(cvr_frame.cache[4]).w[at] = brick;
  atomicMax(CVR_CONTROL.w[CVR_CONTROL_GROUPS], min(at / cvr_push.x + 1u, cvr_push.y));
}
