// What every kernel of scalars includes first.
layout(scalar, set = 0, binding = 0) uniform Frame{
#include "shaders/scalars/frame_fields.glsl"
} cvr_frame;

layout(push_constant) uniform Push { uvec4 cvr_push; };

layout(buffer_reference, std430, buffer_reference_align = 4) buffer Floats { float f[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) buffer Colours { vec4 c[]; };

#define CVR_BUFFER(i) Global(cvr_frame.encoding[i])
#define CVR_BUFFER_AT(i, word) Global(cvr_frame.encoding[i] + 4UL * uint64_t(word))

uvec3 cvr_extent() { return uvec3(cvr_frame.extent[0], cvr_frame.extent[1], cvr_frame.extent[2]); }

// A voxel given in slice space.
uvec3 cvr_voxel(uint p, uint q, uint s) {
  return cvr_frame.axis == 0u   ? uvec3(s, p, q)
         : cvr_frame.axis == 1u ? uvec3(p, s, q)
                                : uvec3(p, q, s);
}
