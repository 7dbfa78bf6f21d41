#include "gpu/scene.hpp"

#include <algorithm>
#include <cmath>

#include "volumes/enum_names.hpp"

namespace cvr::gpu {

namespace {

constexpr double kNarrowestFov = 0.01, kWidestFov = 179;  ///< a spline may overshoot its keys

/// Between b and c, at u in [0, 1], with the keys before and after them (uniform Catmull-Rom
/// spline).
double spline(double a, double b, double c, double d, double u) {
  return b + 0.5 * u * ((c - a) + u * ((2 * a - 5 * b + 4 * c - d) + u * (3 * (b - c) + d - a)));
}

Vector3 spline(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d, double u) {
  Vector3 result;
  for (std::size_t axis = 0; axis < 3; ++axis)
    result[axis] = spline(a[axis], b[axis], c[axis], d[axis], u);
  return result;
}

/// The key that continues the line from `inner` through `end`, so that a path of two keys is
/// straight and even.
Camera beyond(const Camera& end, const Camera& inner) {
  const auto reflect = [](const Vector3& e, const Vector3& i) {
    return Vector3{2 * e[0] - i[0], 2 * e[1] - i[1], 2 * e[2] - i[2]};
  };
  return {reflect(end.eye, inner.eye), reflect(end.target, inner.target), reflect(end.up, inner.up),
          2 * end.vertical_fov_degrees - inner.vertical_fov_degrees};
}

/// Mixes all bits of a label (the finaliser of MurmurHash3).
std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 33)) * 0xFF51AFD7ED558CCDu;
  x = (x ^ (x >> 33)) * 0xC4CEB9FE1A85EC53u;
  return x ^ (x >> 33);
}

/// Any hue, saturation 0.45 .. 0.85, value 0.7 .. 1.
std::array<std::uint8_t, 3> label_colour(std::uint64_t label) {
  const std::uint64_t random = mix(label);
  const auto part = [&](unsigned shift) {
    return static_cast<double>(random >> shift & 0xFFFF) / 65536.0;
  };
  const double hue = 6 * part(0), saturation = 0.45 + 0.4 * part(16), value = 0.7 + 0.3 * part(32);
  std::array<std::uint8_t, 3> colour;
  constexpr std::array kShift{5.0, 3.0,
                              1.0};  // of red, green and blue on the circle of six sectors
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const double k = std::fmod(kShift[channel] + hue, 6.0);
    const double dip = std::clamp(std::min(k, 4 - k), 0.0, 1.0);
    colour[channel] = static_cast<std::uint8_t>(std::lround(255 * value * (1 - saturation * dip)));
  }
  return colour;
}

}  // namespace

double CameraPath::part_of(std::size_t key) const {
  return keys_.size() > 1 ? static_cast<double>(key) / static_cast<double>(keys_.size() - 1) : 0;
}

Camera CameraPath::at(double part) const {
  if (keys_.size() == 1) return keys_.front();
  const std::size_t last = keys_.size() - 1;
  const double place = std::clamp(part, 0.0, 1.0) * static_cast<double>(last);
  const std::size_t i = std::min(static_cast<std::size_t>(place), last - 1);
  const double u = place - static_cast<double>(i);
  const Camera &b = keys_[i], &c = keys_[i + 1];
  if (u == 0) return b;
  if (u == 1) return c;
  const Camera a = i > 0 ? keys_[i - 1] : beyond(b, c);
  const Camera d = i + 2 <= last ? keys_[i + 2] : beyond(c, b);
  Camera camera{spline(a.eye, b.eye, c.eye, d.eye, u),
                spline(a.target, b.target, c.target, d.target, u),
                spline(a.up, b.up, c.up, d.up, u),
                spline(a.vertical_fov_degrees, b.vertical_fov_degrees, c.vertical_fov_degrees,
                       d.vertical_fov_degrees, u)};
  camera.vertical_fov_degrees = std::clamp(camera.vertical_fov_degrees, kNarrowestFov, kWidestFov);
  return camera;
}

namespace {

constexpr auto kShadingNames = volumes::enum_names<Shading>(
    {{Shading::kLocal, "local"}, {Shading::kShadow, "shadow"}, {Shading::kAo, "ao"}});

}  // namespace

std::string_view name_of(Shading shading) { return kShadingNames.of(shading); }

std::optional<Shading> shading_from_name(std::string_view name) { return kShadingNames.find(name); }

Camera Scene::camera(std::uint32_t n) const {
  if (path_parts == 0 || frames >= path_frames)
    return path.at(frames > 1 ? static_cast<double>(n) / (frames - 1) : 0);
  const std::uint32_t asked = std::min(path_parts, frames), each = (frames + asked - 1) / asked;
  const std::uint32_t parts = (frames + each - 1) / each;  // that there are frames for
  const std::uint32_t last_start = path_frames - each, part = n / each;
  const double start =
      parts > 1 ? std::floor(static_cast<double>(last_start) * part / (parts - 1)) : 0;
  return path.at((start + n % each) / (path_frames - 1));
}

Rgba Scene::material(std::uint64_t label) const {
  for (const MaterialRule& rule : materials) {
    if (label < rule.first || label > rule.last || label % rule.modulus != rule.remainder) continue;
    const auto colour = rule.colour ? *rule.colour : label_colour(label);
    const double opacity = std::clamp(rule.opacity, 0.0, 1.0);
    return {colour[0], colour[1], colour[2], static_cast<std::uint8_t>(std::lround(255 * opacity))};
  }
  return {};
}

Vector3 world_scale(const volumes::VolumeInfo& info) {
  const auto& size = info.voxel_size;
  const double smallest = std::min({size[0], size[1], size[2]});
  return {size[0] / smallest, size[1] / smallest, size[2] / smallest};
}

double world_size(const volumes::VolumeInfo& info) {
  const Vector3 scale = world_scale(info);
  return std::max({static_cast<double>(info.extent.x) * scale[0],
                   static_cast<double>(info.extent.y) * scale[1],
                   static_cast<double>(info.extent.z) * scale[2]});
}

Vector3 world_from_scene(const volumes::VolumeInfo& info, const Vector3& point) {
  const Vector3 scale = world_scale(info);
  const double size = world_size(info);
  return {point[0] * size + 0.5 * static_cast<double>(info.extent.x) * scale[0],
          point[1] * size + 0.5 * static_cast<double>(info.extent.y) * scale[1],
          point[2] * size + 0.5 * static_cast<double>(info.extent.z) * scale[2]};
}

}  // namespace cvr::gpu
