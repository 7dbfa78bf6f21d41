// `raw`: voxels as they are. Buffer 0: voxels, x fastest. Constant: CVR_RAW_SCALAR 0 u8, 1 u16, 2
// i16, 3 f32.
#include "shaders/shared/portable.glsl"

CVR_FUNC float cvr_sample(uvec3 voxel) {
  uvec3 extent = cvr_extent();
  uint64_t at = uint64_t(voxel.x) +
                uint64_t(extent.x) * (uint64_t(voxel.y) + uint64_t(extent.y) * uint64_t(voxel.z));
#if CVR_RAW_SCALAR == 3
  return uintBitsToFloat(cvr_read_global(CVR_BUFFER_AT(0, at), 0u));
#elif CVR_RAW_SCALAR == 0
  return float((cvr_read_global(CVR_BUFFER_AT(0, at >> 2), 0u) >> (8u * (uint(at) & 3u))) & 255u);
#else
  uint value = (cvr_read_global(CVR_BUFFER_AT(0, at >> 1), 0u) >> (16u * (uint(at) & 1u))) & 65535u;
#if CVR_RAW_SCALAR == 2
  return float(int(value << 16) >> 16);
#else
  return float(value);
#endif
#endif
}

vec4 cvr_samples(uvec3 voxel) {
  uint last = cvr_extent().x - 1u;
  return vec4(cvr_sample(voxel), cvr_sample(uvec3(min(voxel.x + 1u, last), voxel.yz)),
              cvr_sample(uvec3(min(voxel.x + 2u, last), voxel.yz)),
              cvr_sample(uvec3(min(voxel.x + 3u, last), voxel.yz)));
}
