// Which nodes of a brick lie inside the volume.
#ifndef CVR_BRICK_LIMITS_GLSL
#define CVR_BRICK_LIMITS_GLSL

#include "shaders/shared/morton.glsl"
#include "shaders/shared/portable.glsl"

// Voxels of a brick of 2^shift a side along an axis that lie inside the volume.
CVR_FUNC uint cvr_brick_valid(uint brick, uint extent, uint shift) {
  uint rest = extent - (brick << shift);
  uint edge = 1u << shift;
  return rest < edge ? rest : edge;
}

// The first code beyond the volume along each axis, of a level whose nodes cover 2^below voxels a
// side. valid_*: as cvr_brick_valid gives them.
struct SerialLimits {
  uint x;
  uint y;
  uint z;
};

CVR_FUNC SerialLimits cvr_serial_limits(uint valid_x, uint valid_y, uint valid_z, uint below) {
  SerialLimits limits;
  limits.x = cvr_morton_spread(((valid_x - 1u) >> below) + 1u);
  limits.y = cvr_morton_spread(((valid_y - 1u) >> below) + 1u) << 1;
  limits.z = cvr_morton_spread(((valid_z - 1u) >> below) + 1u) << 2;
  return limits;
}

// Spread bits are in the order of the coordinates.
CVR_FUNC bool cvr_serial_is_inside(SerialLimits limits, uint n) {
  return (n & CVR_MORTON_X) < limits.x && (n & (CVR_MORTON_X << 1)) < limits.y &&
         (n & (CVR_MORTON_X << 2)) < limits.z;
}

#endif
