// Small vectors of doubles for the reference renderer.
#pragma once

#include <cmath>

#include "gpu/scene.hpp"

namespace cvr::gpu {

inline Vector3 operator+(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vector3 operator-(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vector3 operator*(double s, const Vector3& a) { return {s * a[0], s * a[1], s * a[2]}; }
/// Component by component.
inline Vector3 operator*(const Vector3& a, const Vector3& b) {
  return {a[0] * b[0], a[1] * b[1], a[2] * b[2]};
}
inline Vector3 operator/(const Vector3& a, const Vector3& b) {
  return {a[0] / b[0], a[1] / b[1], a[2] / b[2]};
}

inline double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vector3& a) { return std::sqrt(dot(a, a)); }
inline Vector3 normalize(const Vector3& a) { return (1 / length(a)) * a; }

/// The axis along which a vector is longest, x before y before z.
inline std::size_t longest_axis(const Vector3& a) {
  std::size_t axis = 0;
  for (std::size_t other = 1; other < 3; ++other) {
    if (std::abs(a[other]) > std::abs(a[axis])) axis = other;
  }
  return axis;
}

}  // namespace cvr::gpu
