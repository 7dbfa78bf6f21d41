#include "gpu/rays.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cvr::gpu {

namespace {

constexpr double kUnits = 1073741824;  // 2^30
constexpr double kPosition = 1048576;  // 2^20
constexpr double kFurthest = 4194304;  // 2^22 voxels
constexpr double kFraction = 65536;    // 2^16

Vector3 minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vector3 normalized(const Vector3& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

}  // namespace

IntegerCamera integer_camera(const volumes::VolumeInfo& info, const Camera& camera,
                             std::uint32_t width, std::uint32_t height) {
  const Vector3 scale = world_scale(info);
  const Vector3 eye = world_from_scene(info, camera.eye);
  const Vector3 forward = normalized(minus(camera.target, camera.eye));
  const Vector3 right = normalized(cross(forward, camera.up));
  const Vector3 up = cross(right, forward);
  const double tangent = std::tan(camera.vertical_fov_degrees * std::numbers::pi / 360);
  const double half_right = tangent / height,
               half_down = -tangent / height;  // square pixels: the same step on both axes
  double largest = 0;
  for (std::size_t b = 0; b < 3; ++b) {
    const double reach = std::abs(forward[b]) + width * std::abs(half_right * right[b]) +
                         height * std::abs(half_down * up[b]);
    largest = std::max(largest, reach / scale[b]);
  }
  IntegerCamera integers{};
  for (std::size_t b = 0; b < 3; ++b) {
    const double unit = kUnits / largest * kFraction / scale[b];
    integers.eye[b] =
        std::llround(std::clamp(eye[b] / scale[b], -kFurthest, kFurthest) * kPosition);
    integers.towards[b] = std::llround(forward[b] * unit);
    integers.right[b] = std::llround(right[b] * half_right * unit);
    integers.down[b] = std::llround(up[b] * half_down * unit);
  }
  return integers;
}

std::array<std::int64_t, 3> integer_direction(const Vector3& direction) {
  const double largest =
      std::max({std::abs(direction[0]), std::abs(direction[1]), std::abs(direction[2])});
  std::array<std::int64_t, 3> integers{};
  for (std::size_t b = 0; b < 3; ++b) integers[b] = std::llround(direction[b] / largest * kUnits);
  return integers;
}

}  // namespace cvr::gpu
