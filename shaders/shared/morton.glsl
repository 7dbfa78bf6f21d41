// 3D Morton codes: bit 3k of the code is bit k of x, bit 3k+1 of y, bit 3k+2 of z. Up to 10 bits an
// axis.
#ifndef CVR_MORTON_GLSL
#define CVR_MORTON_GLSL

#include "shaders/shared/portable.glsl"

#define CVR_MORTON_X 0x09249249u

// Spreads the low 10 bits of v to every third bit.
CVR_FUNC uint cvr_morton_spread(uint v) {
  v = (v | (v << 16)) & 0x030000ffu;
  v = (v | (v << 8)) & 0x0300f00fu;
  v = (v | (v << 4)) & 0x030c30c3u;
  v = (v | (v << 2)) & CVR_MORTON_X;
  return v;
}

CVR_FUNC uint cvr_morton_encode(uint x, uint y, uint z) {
  return cvr_morton_spread(x) | (cvr_morton_spread(y) << 1) | (cvr_morton_spread(z) << 2);
}

// Collects every third bit of v, beginning with bit 0.
CVR_FUNC uint cvr_morton_gather(uint v) {
  v = v & CVR_MORTON_X;
  v = (v | (v >> 2)) & 0x030c30c3u;
  v = (v | (v >> 4)) & 0x0300f00fu;
  v = (v | (v >> 8)) & 0x030000ffu;
  v = (v | (v >> 16)) & 0x000003ffu;
  return v;
}

// The code of the neighbour at -1 along an axis (0 x, 1 y, 2 z). The coordinate must not be 0.
CVR_FUNC uint cvr_morton_minus(uint code, uint axis) {
  uint mask = CVR_MORTON_X << axis;
  return (((code & mask) - 1u) & mask) | (code & ~mask);
}

// The code of the neighbour at +1 along an axis.
CVR_FUNC uint cvr_morton_plus(uint code, uint axis) {
  uint mask = CVR_MORTON_X << axis;
  return (((code | ~mask) + 1u) & mask) | (code & ~mask);
}

#endif
