// `vq`, `hvq`, `tvq`: one record of codes a block, one entry of each book a voxel. Buffer 0: rows, books and records (shaders/shared/tvq.glsl).
//
// Constants: CVR_TVQ_READ books that are read; CVR_TVQ_EDGE voxels a side of a sub-volume, 0: one for the whole; CVR_TVQ_FLOAT 1: f32;
//            CVR_TVQ_FRACTION, _ZERO, _LOW, _HIGH, _OFFSET, _STEP_A, _STEP_B the domain, floats as their bits;
//            CVR_TVQ_ROW_0 .. _16 the row of the only sub-volume
#include "shaders/shared/tvq.glsl"

TvqRow cvr_row_of(uint part) {
#if CVR_TVQ_EDGE == 0
  TvqRow row;
  row.records = uint(CVR_TVQ_ROW_0);
  row.record_bits = uint(CVR_TVQ_ROW_1);
  row.dc_bits = uint(CVR_TVQ_ROW_2);
  row.dc_base = uint(CVR_TVQ_ROW_3);
  row.dc_step = uint(CVR_TVQ_ROW_4);
  row.bits = uint[](uint(CVR_TVQ_ROW_5), uint(CVR_TVQ_ROW_9), uint(CVR_TVQ_ROW_13));
  row.first = uint[](uint(CVR_TVQ_ROW_6), uint(CVR_TVQ_ROW_10), uint(CVR_TVQ_ROW_14));
  row.scale = uint[](uint(CVR_TVQ_ROW_7), uint(CVR_TVQ_ROW_11), uint(CVR_TVQ_ROW_15));
  row.flags = uint[](uint(CVR_TVQ_ROW_8), uint(CVR_TVQ_ROW_12), uint(CVR_TVQ_ROW_16));
  return row;
#else
  return cvr_tvq_row(CVR_BUFFER(0), part * CVR_TVQ_ROW);
#endif
}

float cvr_sample(uvec3 voxel) {
  uvec3 inside = voxel;
  uvec3 extent = cvr_extent();
  uint part = 0u;
#if CVR_TVQ_EDGE != 0
  const uint edge = uint(CVR_TVQ_EDGE);
  uvec3 grid = (extent + (edge - 1u)) / edge;
  uvec3 at = voxel / edge;
  part = at.x + grid.x * (at.y + grid.y * at.z);
  inside = voxel - at * edge;
  extent = min(uvec3(edge), extent - at * edge);
#endif
  uvec2 blocks = (extent.xy + 3u) >> 2;
  uvec3 block = inside >> 2;
  uint64_t n = uint64_t(block.x) + uint64_t(blocks.x) * (uint64_t(block.y) + uint64_t(blocks.y) * uint64_t(block.z));
  uint i = (inside.x & 3u) + 4u * (inside.y & 3u) + 16u * (inside.z & 3u);
  int sum = cvr_tvq_sum(CVR_BUFFER(0), cvr_row_of(part), n, i, uint(CVR_TVQ_READ));
  TvqDomain domain = TvqDomain(uint(CVR_TVQ_FRACTION), int(CVR_TVQ_ZERO), int(CVR_TVQ_LOW), int(CVR_TVQ_HIGH),
                               uintBitsToFloat(uint(CVR_TVQ_OFFSET)), uintBitsToFloat(uint(CVR_TVQ_STEP_A)),
                               uintBitsToFloat(uint(CVR_TVQ_STEP_B)));
#if CVR_TVQ_FLOAT == 1
  return cvr_tvq_float(domain, sum);
#else
  return float(cvr_tvq_integer(domain, sum));
#endif
}
