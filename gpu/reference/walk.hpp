// The cells along a ray, in the order in which it visits them (IMAGE.md, Traversal).
//
// A ray crosses planes x = i, y = j, z = k. Each crossing has a parameter t = (plane - origin) /
// direction and an axis, and crossings are ordered by t, then by axis. Between two crossings the
// ray is in one voxel, the voxel in one brick, and the brick says which cell of which level that
// is. A Walk holds such a state and finds the next crossing that leaves the cell. All decisions
// compare the same quotients, so they agree with each other even where rounding makes crossings
// meet. A brick without visible labels is walked in one step.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gpu/reference/view.hpp"

namespace cvr::gpu {

class Walk {
 public:
  /// Goes to the first cell of the ray; at_end() at once if it misses the volume, or the direction
  /// is zero or not finite.
  Walk(const View& view, const ReferenceRenderer::Ray& ray);

  bool at_end() const { return at_end_; }
  void next();

  double t() const { return t_; }  ///< where the cell was entered
  /// The axis of the face through which the cell was entered; none for a ray that begins in the
  /// cell.
  std::optional<std::size_t> face() const { return face_; }
  /// The coordinate of that face.
  std::int64_t face_plane() const { return face_plane_; }
  std::uint64_t brick() const { return brick_; }
  bool visible_brick() const { return brick_level_ != kInvisibleBrick; }
  unsigned level() const { return level_; }
  /// Index of the cell in its level; in a visible brick.
  std::uint64_t cell_index() const;
  /// In a visible brick.
  std::uint64_t label() const;

 private:
  bool enter();
  double time_of(std::size_t axis, std::int64_t plane) const {
    return (static_cast<double>(plane) - origin_[axis]) / direction_[axis];
  }
  std::int64_t voxel_at(std::size_t axis, double t, bool crossed_at_t) const;
  void enter_brick();
  void set_next_plane(std::size_t axis);
  std::uint64_t brick_of_voxel() const;

  const View& view_;
  Vector3 origin_, direction_;
  std::array<std::int64_t, 3> extent_;
  std::array<std::int64_t, 3> voxel_{};  ///< exact where a brick was entered, in the cell elsewhere
  std::array<std::int64_t, 3> cell_low_{};    ///< first voxel of the cell
  std::array<std::int64_t, 3> next_plane_{};  ///< by which the cell is left on each axis
  std::array<double, 3> next_t_{};  ///< when; infinite on an axis along which the ray does not move
  std::uint64_t brick_ = 0;
  std::uint8_t brick_level_ = kInvisibleBrick;
  unsigned level_ = 0;
  double t_ = 0;
  std::optional<std::size_t> face_;
  std::int64_t face_plane_ = 0;
  bool at_end_ = false;
};

}  // namespace cvr::gpu
