// `vq`, `hvq`, `tvq`: one record of codes a block, one entry of each book a voxel. Buffer 0: rows,
// books and records (shaders/shared/tvq.glsl).
//
// Constants: CVR_TVQ_READ books that are read; CVR_TVQ_EDGE voxels per side of a sub-volume, 0: one
// for the whole; CVR_TVQ_FLOAT 1: f32;
//            CVR_TVQ_FRACTION, _ZERO, _LOW, _HIGH, _OFFSET, _STEP_A, _STEP_B the domain, floats as
//            their bits;
//            CVR_TVQ_ROW_0 .. _16 the row of the only sub-volume
#include "shaders/shared/portable.glsl"
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

// Where a voxel lies: the row of its sub-volume, the number of its block there, and its number in
// the block.
struct TvqPlace {
  TvqRow row;
  uint64_t block;
  uint i;
};

TvqPlace cvr_place_of(uvec3 voxel) {
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
  TvqPlace place;
  place.row = cvr_row_of(part);
  place.block = uint64_t(block.x) +
                uint64_t(blocks.x) * (uint64_t(block.y) + uint64_t(blocks.y) * uint64_t(block.z));
  place.i = (inside.x & 3u) + 4u * (inside.y & 3u) + 16u * (inside.z & 3u);
  return place;
}

float cvr_scalar_of(int sum) {
  TvqDomain domain =
      TvqDomain(uint(CVR_TVQ_FRACTION), int(CVR_TVQ_ZERO), int(CVR_TVQ_LOW), int(CVR_TVQ_HIGH),
                uintBitsToFloat(uint(CVR_TVQ_OFFSET)), uintBitsToFloat(uint(CVR_TVQ_STEP_A)),
                uintBitsToFloat(uint(CVR_TVQ_STEP_B)));
#if CVR_TVQ_FLOAT == 1
  return cvr_tvq_float(domain, sum);
#else
  return float(cvr_tvq_integer(domain, sum));
#endif
}

float cvr_sample(uvec3 voxel) {
  TvqPlace place = cvr_place_of(voxel);
  return cvr_scalar_of(
      cvr_tvq_sum(CVR_BUFFER(0), place.row, place.block, place.i, uint(CVR_TVQ_READ)));
}

vec4 cvr_samples(uvec3 voxel) {
  TvqPlace place = cvr_place_of(voxel);
  TvqRun run = cvr_tvq_run(CVR_BUFFER(0), place.row, place.block, place.i >> 2, uint(CVR_TVQ_READ));
  return vec4(cvr_scalar_of(run.sum[0]), cvr_scalar_of(run.sum[1]), cvr_scalar_of(run.sum[2]),
              cvr_scalar_of(run.sum[3]));
}
