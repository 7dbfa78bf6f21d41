// Where a brick lies among groups of bricks, 2^shift a side, which have one entry in the start
// table.
//
// Buffers: 0 starts   first word of each group and the end, groups x fastest
//          1 bricks   the groups
#include "shaders/shared/portable.glsl"

// The word at which a brick's group begins.
CVR_FUNC uint64_t cvr_group_word(uvec3 brick, uint shift) {
  uvec3 group = brick >> shift;
  uvec3 groups = (cvr_grid() + ((1u << shift) - 1u)) >> shift;
  return uint64_t(
      cvr_read_global(CVR_BUFFER(0), group.x + groups.x * (group.y + groups.y * group.z)));
}

// The bricks of its group along each axis: fewer at the border of the volume.
CVR_FUNC uvec3 cvr_group_bricks(uvec3 brick, uint shift) {
  uint edge = 1u << shift;
  return min(cvr_grid() - ((brick >> shift) << shift), uvec3(edge, edge, edge));
}

// Its place in its group, x fastest.
CVR_FUNC uint cvr_group_member(uvec3 brick, uint shift) {
  uvec3 bricks = cvr_group_bricks(brick, shift);
  uvec3 at = brick & ((1u << shift) - 1u);
  return at.x + bricks.x * (at.y + bricks.y * at.z);
}
