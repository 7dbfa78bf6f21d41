// The operations of the CSGV family: what a node's label is taken from.
#ifndef CVR_OPERATIONS_GLSL
#define CVR_OPERATIONS_GLSL

#include "shaders/shared/morton.glsl"
#include "shaders/shared/portable.glsl"

#define CVR_OP_PARENT 0u
#define CVR_OP_NEIGHBOUR_X 1u
#define CVR_OP_NEIGHBOUR_Y 2u
#define CVR_OP_NEIGHBOUR_Z 3u
#define CVR_OP_ADVANCE 4u
#define CVR_OP_LAST 5u
#define CVR_OP_DELTA 6u  // csgv alone

// Moves from a node to the one that its operation (parent or neighbour) refers to. Child bit 0
// along the axis: the neighbour at -1 on the same level; child bit 1: the parent's neighbour at +1.
// False if that leaves the brick: no encoder writes it.
CVR_FUNC bool cvr_csgvr_follow(uint operation, CVR_INOUT(uint) n, CVR_INOUT(uint) level) {
  if (level == 0u) return false;
  if (operation == CVR_OP_PARENT) {
    n >>= 3;
    level -= 1u;
    return true;
  }
  uint axis = operation - CVR_OP_NEIGHBOUR_X;
  uint mask = CVR_MORTON_X << axis;
  if (((n >> axis) & 1u) == 0u) {
    if ((n & mask) == 0u) return false;
    n = cvr_morton_minus(n, axis);
    return true;
  }
  n >>= 3;
  level -= 1u;
  uint inside = (1u << (3u * level)) - 1u;
  if ((n & mask) == (mask & inside)) return false;
  n = cvr_morton_plus(n, axis);
  return true;
}

#endif
