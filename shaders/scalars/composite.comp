// Front-to-back compositing of the sample planes between slices (gpu/IMAGE.md, Scalars); one
// invocation a pixel. cvr_push.x, .y: slabs, counted in the order of the view, from the first to
// the one behind the last; .z: 1 in the first dispatch of a frame, .w: 1 in the last.
//   CVR_FROM_RING   values come from the ring of decoded slices: deferred filtering. Else each is decoded where it is needed.
#include "shaders/scalars/offset.glsl"

layout(local_size_x = CVR_GROUP) in;

const float CVR_LEAST_TRANSMITTANCE = 1.0 / 256.0;
const float CVR_LEAST_ALONG =
    1.0 / 1024.0;  // of a direction along the slice axis against its largest component

// Above value_at.
float cvr_value(ivec3 voxel) {
  ivec3 last = ivec3(cvr_frame.slices[0], cvr_frame.slices[1], cvr_frame.slices[2]) - 1;
  uvec3 at = uvec3(clamp(voxel, ivec3(0), last));
#ifdef CVR_FROM_RING
  uint row = cvr_frame.slices[0];
  return Floats(cvr_frame.ring)
      .f[at.x + row * (at.y + cvr_frame.slices[1] * (at.z & (cvr_frame.ring_slices - 1u)))];
#else
  return cvr_offset_sample(cvr_voxel(at.x, at.y, at.z));
#endif
}

// Weight of the voxel at -1, 0, 1, 2 beside a position `part` of the way from 0 to 1: of the value,
// and of its central difference.
float cvr_value_weight(int i, float part) { return i == 0 ? 1.0 - part : i == 1 ? part : 0.0; }
float cvr_slope_weight(int i, float part) {
  return 0.5 * (cvr_value_weight(i - 1, part) - cvr_value_weight(i + 1, part));
}

vec4 cvr_transfer(float value) {
  float entry = clamp(value * cvr_frame.value_step, 0.0, float(CVR_TRANSFER_ENTRIES - 1));
  float below = min(floor(entry), float(CVR_TRANSFER_ENTRIES - 2));
  Colours entries = Colours(cvr_frame.transfer);
  return mix(entries.c[uint(below)], entries.c[uint(below) + 1u], entry - below);
}

void cvr_take(vec3 position, float world_step, inout vec4 sum) {
  ivec3 base = ivec3(floor(position));
  vec3 part = position - vec3(base);
  float value = 0.0;
  for (int i = 0; i < 8; ++i) {
    ivec3 corner = ivec3(i & 1, (i >> 1) & 1, i >> 2);
    float weight = cvr_value_weight(corner.x, part.x) * cvr_value_weight(corner.y, part.y) *
                   cvr_value_weight(corner.z, part.z);
    value += weight * cvr_value(base + corner);
  }
  vec4 entry = cvr_transfer(value);
  bool seen = entry.w > 0.0;
  vec3 slope = vec3(0.0);
  // The voxels of the 4^3 around the position that lie outside the cell along one axis at most:
  // others have no weight.
  for (int i = 0; i < (seen ? 64 : 0); ++i) {
    ivec3 at = ivec3(i & 3, (i >> 2) & 3, i >> 4) - 1;
    ivec3 outside = ivec3(notEqual(clamp(at, 0, 1), at));
    if (outside.x + outside.y + outside.z > 1) continue;
    vec3 flat_ = vec3(cvr_value_weight(at.x, part.x), cvr_value_weight(at.y, part.y),
                      cvr_value_weight(at.z, part.z));
    vec3 steep = vec3(cvr_slope_weight(at.x, part.x), cvr_slope_weight(at.y, part.y),
                      cvr_slope_weight(at.z, part.z));
    slope += cvr_value(base + at) * vec3(steep.x * flat_.y * flat_.z, flat_.x * steep.y * flat_.z,
                                         flat_.x * flat_.y * steep.z);
  }
  if (!seen) return;
  slope /= vec3(cvr_frame.scale[0], cvr_frame.scale[1], cvr_frame.scale[2]);
  float steepness = length(slope);
  float lambert = 1.0;
  if (steepness > 0.0) {
    vec3 light = vec3(cvr_frame.light[0], cvr_frame.light[1], cvr_frame.light[2]);
    float shaded = cvr_frame.knee > 0.0 ? min(steepness / cvr_frame.knee, 1.0) : 1.0;
    lambert = 1.0 - shaded * (1.0 - cvr_frame.ambient) * (1.0 - abs(dot(slope, light)) / steepness);
  }
  float alpha = 1.0 - exp(-entry.w * world_step);
  sum.rgb += sum.w * alpha * lambert * entry.rgb;
  sum.w *= 1.0 - alpha;
}

void main() {
  uint pixel = gl_GlobalInvocationID.x;
  if (pixel >= cvr_frame.width * cvr_frame.height) return;
  uint px = pixel % cvr_frame.width;
  uint py = pixel / cvr_frame.width;
  vec4 sum = cvr_push.z != 0u ? vec4(0.0, 0.0, 0.0, 1.0) : Colours(cvr_frame.colours).c[pixel];
  vec3 eye = vec3(cvr_frame.eye[0], cvr_frame.eye[1], cvr_frame.eye[2]);
  vec3 direction = vec3(cvr_frame.towards[0], cvr_frame.towards[1], cvr_frame.towards[2]) +
                   (float(2u * px + 1u) - float(cvr_frame.width)) *
                       vec3(cvr_frame.right[0], cvr_frame.right[1], cvr_frame.right[2]) +
                   (float(2u * py + 1u) - float(cvr_frame.height)) *
                       vec3(cvr_frame.down[0], cvr_frame.down[1], cvr_frame.down[2]);
  float along = cvr_frame.backwards != 0u ? -direction.z : direction.z;
  bool crosses = along > CVR_LEAST_ALONG * max(abs(direction.x), abs(direction.y));
  vec3 scale = vec3(cvr_frame.scale[0], cvr_frame.scale[1], cvr_frame.scale[2]);
  float world_step = crosses ? length(direction * scale) / (along * float(cvr_frame.samples)) : 0.0;
  vec2 edge = vec2(cvr_frame.slices[0], cvr_frame.slices[1]) - 0.5;
  uint planes = crosses ? (cvr_push.y - cvr_push.x) * cvr_frame.samples : 0u;
  for (uint i = 0u; i < planes; ++i) {
    uint plane = cvr_push.x * cvr_frame.samples + i;
    float depth = (float(plane) + 0.5) / float(cvr_frame.samples);
    float s = cvr_frame.backwards != 0u ? float(cvr_frame.slices[2] - 1u) - depth : depth;
    float t = (s - eye.z) / direction.z;
    vec2 at = eye.xy + t * direction.xy;
    bool inside = t >= 0.0 && all(greaterThanEqual(at, vec2(-0.5))) && all(lessThan(at, edge));
    if (inside && sum.w >= CVR_LEAST_TRANSMITTANCE) cvr_take(vec3(at, s), world_step, sum);
  }
  if (cvr_push.w != 0u) {
    sum.rgb +=
        sum.w * vec3(cvr_frame.background[0], cvr_frame.background[1], cvr_frame.background[2]);
  }
  Colours(cvr_frame.colours).c[pixel] = sum;
}
