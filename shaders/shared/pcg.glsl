// Hash functions of two, three and four words (pcg2d, pcg3d and pcg4d of Jarzynski and Olano: Hash
// Functions for GPU Rendering, JCGT 2020). Each takes its words and leaves mixed ones.
#ifndef CVR_PCG_GLSL
#define CVR_PCG_GLSL

#include "shaders/shared/portable.glsl"

#define CVR_PCG_FACTOR 1664525u

// A step of the linear congruential generator.
CVR_FUNC uint cvr_pcg_step(uint x) { return x * CVR_PCG_FACTOR + 1013904223u; }
CVR_FUNC uint cvr_pcg_fold(uint x) { return x ^ (x >> 16); }

CVR_FUNC void cvr_pcg2d_mix(CVR_INOUT(uint) x, CVR_INOUT(uint) y) {
  x += y * CVR_PCG_FACTOR;
  y += x * CVR_PCG_FACTOR;
  x = cvr_pcg_fold(x);
  y = cvr_pcg_fold(y);
}

CVR_FUNC void cvr_pcg2d(CVR_INOUT(uint) x, CVR_INOUT(uint) y) {
  x = cvr_pcg_step(x);
  y = cvr_pcg_step(y);
  cvr_pcg2d_mix(x, y);
  cvr_pcg2d_mix(x, y);
}

CVR_FUNC void cvr_pcg3d_mix(CVR_INOUT(uint) x, CVR_INOUT(uint) y, CVR_INOUT(uint) z) {
  x += y * z;
  y += z * x;
  z += x * y;
}

CVR_FUNC void cvr_pcg3d(CVR_INOUT(uint) x, CVR_INOUT(uint) y, CVR_INOUT(uint) z) {
  x = cvr_pcg_step(x);
  y = cvr_pcg_step(y);
  z = cvr_pcg_step(z);
  cvr_pcg3d_mix(x, y, z);
  x = cvr_pcg_fold(x);
  y = cvr_pcg_fold(y);
  z = cvr_pcg_fold(z);
  cvr_pcg3d_mix(x, y, z);
}

CVR_FUNC void cvr_pcg4d_mix(CVR_INOUT(uint) x, CVR_INOUT(uint) y, CVR_INOUT(uint) z,
                            CVR_INOUT(uint) w) {
  x += y * w;
  y += z * x;
  z += x * y;
  w += y * z;
}

CVR_FUNC void cvr_pcg4d(CVR_INOUT(uint) x, CVR_INOUT(uint) y, CVR_INOUT(uint) z,
                        CVR_INOUT(uint) w) {
  x = cvr_pcg_step(x);
  y = cvr_pcg_step(y);
  z = cvr_pcg_step(z);
  w = cvr_pcg_step(w);
  cvr_pcg4d_mix(x, y, z, w);
  x = cvr_pcg_fold(x);
  y = cvr_pcg_fold(y);
  z = cvr_pcg_fold(z);
  w = cvr_pcg_fold(w);
  cvr_pcg4d_mix(x, y, z, w);
}

#endif
