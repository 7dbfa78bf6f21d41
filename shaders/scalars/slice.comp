// Deferred filtering, first pass: decodes the slices cvr_push.x to cvr_push.y - 1 into the ring;
// one invocation four voxels side by side along p, which share a block where p is x.
#include "shaders/scalars/offset.glsl"

layout(local_size_x = CVR_GROUP) in;

void main() {
  uint width = cvr_frame.slices[0];
  uint runs = (width + 3u) >> 2;
  uint in_slice = runs * cvr_frame.slices[1];
  uint i = gl_GlobalInvocationID.x;
  if (i >= in_slice * (cvr_push.y - cvr_push.x)) return;
  uint n = i / in_slice;
  uint slice = cvr_push.x + n;
  uint inside = i - n * in_slice;
  uint q = inside / runs;
  uint p = 4u * (inside - q * runs);
  vec4 values;
  if (cvr_frame.axis != 0u) {
    values = cvr_offset_samples(cvr_voxel(p, q, slice));
  } else {
    for (uint k = 0u; k < 4u; ++k)
      values[k] = cvr_offset_sample(cvr_voxel(min(p + k, width - 1u), q, slice));
  }
  uint at = (slice & (cvr_frame.ring_slices - 1u)) * width * cvr_frame.slices[1] + q * width + p;
  for (uint k = 0u; k < 4u; ++k) {
    if (p + k < width) Floats(cvr_frame.ring).f[at + k] = values[k];
  }
}
