// Second pass: gives each requested brick a region, from its level's stack or from the untouched
// end, and lists it for decoding. cvr_push.x: invocations of a decoding workgroup that take a brick
// each; cvr_push.y: most workgroups of a dispatch.
#include "shaders/caches/brick_state.glsl"

layout(local_size_x = 64) in;

// Adds and takes back in place of a loop of compare-and-swap, over which thousands of invocations
// would wait for each other. The stacks hold regions of one size and only shrink in this pass, so
// who took one too many gives one back. Regions at the untouched end have many sizes: there the
// addition is taken back only if nobody has added since. Else what follows it could be given away
// twice, so the counter stays too high, and what lies behind it is not there for anybody until the
// host empties the cache.
bool cvr_allocate(uint lod, out uint unit) {
  if (int(CVR_CONTROL.w[CVR_CONTROL_FREE + lod]) > 0) {
    int available = int(atomicAdd(CVR_CONTROL.w[CVR_CONTROL_FREE + lod], ~0u));
    if (available > 0) {
      unit = Words32(cvr_frame.cache[3]).w[lod * cvr_frame.cache_sizes[1] + uint(available) - 1u];
      return true;
    }
    atomicAdd(CVR_CONTROL.w[CVR_CONTROL_FREE + lod], 1u);
  }
  uint units = cvr_units_of(lod);
  if (units > cvr_frame.cache_sizes[0]) return false;
  uint last = cvr_frame.cache_sizes[0] - units;
  if (CVR_CONTROL.w[CVR_CONTROL_BUMP] > last) return false;
  unit = atomicAdd(CVR_CONTROL.w[CVR_CONTROL_BUMP], units);
  if (unit <= last) return true;
  atomicCompSwap(CVR_CONTROL.w[CVR_CONTROL_BUMP], unit + units, unit);
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
