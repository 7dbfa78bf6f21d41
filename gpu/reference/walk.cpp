#include "gpu/reference/walk.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace cvr::gpu {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::array<std::int64_t, 3> signed_extent(const volumes::Extent& extent) {
  return {static_cast<std::int64_t>(extent.x), static_cast<std::int64_t>(extent.y),
          static_cast<std::int64_t>(extent.z)};
}

bool usable(const Vector3& origin, const Vector3& direction) {
  bool moves = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(origin[axis]) || !std::isfinite(direction[axis])) return false;
    moves |= direction[axis] != 0;
  }
  return moves;
}

}  // namespace

Walk::Walk(const View& view, const ReferenceRenderer::Ray& ray)
    : view_(view),
      origin_(ray.origin),
      direction_(ray.direction),
      extent_(signed_extent(view.bricks().info().extent)) {
  at_end_ = !usable(origin_, direction_) || !enter();
  if (!at_end_) enter_brick();
}

/// Goes to the crossing by which the ray enters the volume, or to t = 0 inside. False: it misses.
bool Walk::enter() {
  double enter_t = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (direction_[axis] == 0) {
      const double voxel = std::floor(origin_[axis]);
      if (voxel < 0 || voxel >= static_cast<double>(extent_[axis])) return false;
      continue;
    }
    const std::int64_t near = direction_[axis] > 0 ? 0 : extent_[axis];
    const double t = time_of(axis, near);
    if (t > 0 && t >= enter_t) {
      enter_t = t;
      face_ = axis;
      face_plane_ = near;
    }
  }
  if (enter_t == kInfinity) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (direction_[axis] == 0) continue;
    const double leave_t = time_of(axis, direction_[axis] > 0 ? extent_[axis] : 0);
    if (leave_t < enter_t || (leave_t == enter_t && (!face_ || axis <= *face_))) return false;
  }
  t_ = enter_t;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    voxel_[axis] = std::clamp<std::int64_t>(voxel_at(axis, t_, !face_ || axis <= *face_), 0,
                                            extent_[axis] - 1);
  }
  return true;
}

/// The voxel along an axis after all crossings before t, and those at t if `crossed_at_t`.
std::int64_t Walk::voxel_at(std::size_t axis, double t, bool crossed_at_t) const {
  const double direction = direction_[axis];
  if (direction == 0) return static_cast<std::int64_t>(std::floor(origin_[axis]));
  const auto crossed = [&](std::int64_t plane) {
    const double plane_t = time_of(axis, plane);
    return plane_t < t || (crossed_at_t && plane_t == t);
  };
  const double guess =
      std::clamp(origin_[axis] + t * direction, -1.0, static_cast<double>(extent_[axis]) + 1);
  auto voxel = static_cast<std::int64_t>(std::floor(guess));
  if (direction > 0) {
    while (voxel < extent_[axis] && crossed(voxel + 1)) ++voxel;
    while (voxel > 0 && !crossed(voxel)) --voxel;
  } else {
    while (voxel > 0 && crossed(voxel)) --voxel;
    while (voxel < extent_[axis] && !crossed(voxel + 1)) ++voxel;
  }
  return voxel;
}

std::uint64_t Walk::brick_of_voxel() const {
  const auto shift = static_cast<unsigned>(std::countr_zero(view_.bricks().brick()));
  const volumes::Extent& grid = view_.bricks().grid();
  return grid.index({static_cast<std::uint64_t>(voxel_[0] >> shift),
                     static_cast<std::uint64_t>(voxel_[1] >> shift),
                     static_cast<std::uint64_t>(voxel_[2] >> shift)});
}

void Walk::enter_brick() {
  brick_ = brick_of_voxel();
  brick_level_ = view_.level_of(brick_);
  level_ = visible_brick() ? brick_level_ : view_.bricks().levels() - 1;
  for (std::size_t axis = 0; axis < 3; ++axis) set_next_plane(axis);
}

/// The volume's own faces end a cell as well: a cell of a coarser level may reach beyond them.
void Walk::set_next_plane(std::size_t axis) {
  cell_low_[axis] = voxel_[axis] >> level_ << level_;
  next_plane_[axis] = direction_[axis] > 0
                          ? std::min(cell_low_[axis] + (std::int64_t{1} << level_), extent_[axis])
                          : cell_low_[axis];
  next_t_[axis] = direction_[axis] == 0 ? kInfinity : time_of(axis, next_plane_[axis]);
}

void Walk::next() {
  std::size_t axis = 0;
  for (std::size_t other = 1; other < 3; ++other) {
    if (next_t_[other] < next_t_[axis]) axis = other;
  }
  if (next_t_[axis] == kInfinity) {
    at_end_ = true;
    return;
  }
  t_ = next_t_[axis];
  face_ = axis;
  face_plane_ = next_plane_[axis];
  voxel_[axis] = direction_[axis] > 0 ? face_plane_ : face_plane_ - 1;
  if (voxel_[axis] < 0 || voxel_[axis] >= extent_[axis]) {
    at_end_ = true;
    return;
  }
  if (brick_of_voxel() == brick_) {
    set_next_plane(axis);
    return;
  }
  for (std::size_t other = 0; other < 3; ++other) {
    if (other == axis) continue;
    const std::int64_t last =
        std::min(cell_low_[other] + (std::int64_t{1} << level_), extent_[other]) - 1;
    voxel_[other] = std::clamp(voxel_at(other, t_, other < axis), cell_low_[other], last);
  }
  enter_brick();
}

std::uint64_t Walk::cell_index() const {
  return view_.bricks().level(level_).extent().index(
      {static_cast<std::uint64_t>(cell_low_[0] >> level_),
       static_cast<std::uint64_t>(cell_low_[1] >> level_),
       static_cast<std::uint64_t>(cell_low_[2] >> level_)});
}

std::uint64_t Walk::label() const {
  const volumes::Volume& volume = view_.bricks().level(level_);
  const std::uint64_t index = cell_index();
  switch (volume.info().type) {
    case volumes::VoxelType::kU8:
      return volume.voxels<std::uint8_t>()[index];
    case volumes::VoxelType::kU16:
      return volume.voxels<std::uint16_t>()[index];
    case volumes::VoxelType::kU64:
      return volume.voxels<std::uint64_t>()[index];
    default:
      return volume.voxels<std::uint32_t>()[index];
  }
}

}  // namespace cvr::gpu
