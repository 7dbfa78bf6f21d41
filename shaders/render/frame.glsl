// What every kernel includes first: the frame, its buffers, materials and counters.
#include "shaders/render/counters.glsl"

layout(scalar, set = 0, binding = 0) uniform Frame{
#include "shaders/render/frame_fields.glsl"
} cvr_frame;

layout(push_constant) uniform Push { uvec4 cvr_push; };

layout(buffer_reference, std430, buffer_reference_align = 4) buffer Words32 { uint w[]; };
layout(buffer_reference, std430, buffer_reference_align = 8) buffer Words64 { uint64_t w[]; };

#ifdef CVR_INSTRUMENTED
// Counts of an invocation; cvr_keep_counts, which each instrumented kernel calls last, adds them to
// the frame's. Shared counters would make all invocations wait for each other at every count.
uint cvr_counted[CVR_COUNTERS] =
    uint[CVR_COUNTERS](0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
#define CVR_COUNT(counter, n) cvr_counted[counter] += uint(n)
uint cvr_words_touched = 0u;
bool cvr_checking = false;  // what is decoded to check a cache is not the work of the mode
#define CVR_TOUCH_WORD() (cvr_words_touched += cvr_checking ? 0u : 1u)
#define CVR_COUNT_HOPS(n) CVR_COUNT(CVR_COUNT_CHAIN_HOPS, cvr_checking ? 0u : n)
void cvr_keep_counts() {
  cvr_counted[CVR_COUNT_WORDS_TOUCHED] += cvr_words_touched;
  [[unroll]] for (int i = 0; i < CVR_COUNTERS; ++i) {
    if (cvr_counted[i] != 0u) atomicAdd(Words64(cvr_frame.counters).w[i], uint64_t(cvr_counted[i]));
  }
}
#else
#define CVR_COUNT(counter, n)
#define CVR_TOUCH_WORD()
#define CVR_COUNT_HOPS(n)
void cvr_keep_counts() {}
#endif

// The codec's buffers, for its decoder text.
#define CVR_BUFFER(i) Global(cvr_frame.encoding[i])
#define CVR_BUFFER_AT(i, word) Global(cvr_frame.encoding[i] + 4UL * uint64_t(word))

uvec3 cvr_extent() { return uvec3(cvr_frame.extent[0], cvr_frame.extent[1], cvr_frame.extent[2]); }
uvec3 cvr_grid() { return uvec3(cvr_frame.grid[0], cvr_frame.grid[1], cvr_frame.grid[2]); }
uint cvr_brick_number(uvec3 brick) {
  return brick.x + cvr_frame.grid[0] * (brick.y + cvr_frame.grid[1] * brick.z);
}
uvec3 cvr_brick_at(uint index) {
  uint plane = cvr_frame.grid[0] * cvr_frame.grid[1];
  uint z = index / plane;
  uint rest = index - z * plane;
  uint y = rest / cvr_frame.grid[0];
  return uvec3(rest - y * cvr_frame.grid[0], y, z);
}

// RGBA of a label code, 8 bits each, red lowest; 0 where the scene does not show it.
uint cvr_material(uint code) {
#ifdef CVR_MATERIALS_HASHED
  uint slot = (code * 0x9e3779b1u) & cvr_frame.material_slots;
  while (true) {
    uint64_t entry = Words64(cvr_frame.materials).w[slot];
    if (uint(entry >> 32) == 0u) return 0u;  // free: only visible codes are in the table
    if (uint(entry) == code) return uint(entry >> 32);
    slot = (slot + 1u) & cvr_frame.material_slots;
  }
#else
  return code < cvr_frame.material_slots ? Words32(cvr_frame.materials).w[code] : 0u;
#endif
}
uint cvr_opacity(uint rgba) { return rgba >> 24; }
bool cvr_code_visible(uint code) { return cvr_opacity(cvr_material(code)) != 0u; }
