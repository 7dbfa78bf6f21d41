// What is drawn: camera, materials, shading. Plain values; IMAGE.md says what each means. No Vulkan
// in here.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volumes/volume.hpp"

namespace cvr::gpu {

using Vector3 = std::array<double, 3>;

/// In scene space: the volume's centre is the origin, its longest edge has length 1.
struct Camera {
  Vector3 eye{0, 0, 2};
  Vector3 target{0, 0, 0};
  Vector3 up{0, 1, 0};
  double vertical_fov_degrees = 45;  ///< above 0, below 180
  bool operator==(const Camera&) const = default;
};

/// A camera on its way: key frames, passed through at equal steps by Catmull-Rom splines of eye,
/// target, up and field of view.
class CameraPath {
 public:
  CameraPath() = default;
  explicit CameraPath(std::vector<Camera> keys) : keys_(std::move(keys)) {}
  const std::vector<Camera>& keys() const { return keys_; }
  /// The camera at a part in [0, 1] of the path. At least one key.
  Camera at(double part) const;
  /// The part at which the camera passes a key, by its number from 0.
  double part_of(std::size_t key) const;

 private:
  std::vector<Camera> keys_;
};

enum class Shading : std::uint8_t { kLocal, kShadow, kAo };
inline constexpr std::array kShadings{Shading::kLocal, Shading::kShadow, Shading::kAo};
/// "local", "shadow", "ao".
std::string_view name_of(Shading shading);
std::optional<Shading> shading_from_name(std::string_view name);

struct Rgba {
  std::uint8_t r = 0, g = 0, b = 0, a = 0;
  bool operator==(const Rgba&) const = default;
};
inline constexpr std::uint8_t kOpaque = 250;  ///< opacities from here on are surfaces

/// Colour and opacity of labels: the first rule that fits a label counts; a label that none fits is
/// invisible.
struct MaterialRule {
  std::uint64_t first = 0, last = UINT64_MAX;  ///< labels, both included
  std::uint64_t modulus = 1, remainder = 0;    ///< only labels with label % modulus == remainder
  double opacity = 1;                          ///< 0 invisible .. 1
  std::optional<std::array<std::uint8_t, 3>>
      colour;  ///< none: a bright colour derived from the label
  bool operator==(const MaterialRule&) const = default;
};

/// A point of a transfer function.
struct TransferPoint {
  double value = 0;  ///< 0 .. 1 of the volume's value range; ascending from point to point
  std::array<std::uint8_t, 3> colour{};
  double density = 0;  ///< extinction a world unit, from 0
  bool operator==(const TransferPoint&) const = default;
};

struct Scene {
  std::string name, title;
  CameraPath path;
  std::uint32_t path_frames = 64;  ///< of the whole path
  std::uint32_t frames = 64;       ///< that are drawn
  std::uint32_t path_parts =
      0;  ///< 0: they are spread over the path; n: they are n evenly spaced parts of consecutive frames of it
  std::uint32_t held = 0;  ///< number of the key where the camera stands still when a view is held
  std::uint32_t width = 640, height = 360;
  std::vector<MaterialRule> materials;  ///< of label volumes
  std::vector<TransferPoint> transfer;  ///< of scalar volumes
  std::uint32_t slice_samples = 1;      ///< sample planes between two slices of a scalar volume
  Shading shading = Shading::kLocal;
  Vector3 light{0.4, 0.8, 0.45};  ///< towards the light, in world space; need not have length 1
  double ambient = 0.35;          ///< 0 .. 1
  double ao_distance = 0.1;       ///< in scene units, above 0
  bool ao_roulette = false;       ///< ambient occlusion rays by Russian roulette (IMAGE.md)
  double lod_bias = 0;            ///< levels; positive is coarser
  std::uint32_t accumulate = 1;   ///< frames drawn of each camera and averaged
  std::array<std::uint8_t, 3> background{255, 255, 255};

  /// The camera of the n-th frame that is drawn.
  Camera camera(std::uint32_t n) const;
  /// The material of a label under the rules.
  Rgba material(std::uint64_t label) const;
};

/// World units a voxel, axis by axis: voxel size / smallest voxel size.
Vector3 world_scale(const volumes::VolumeInfo& info);
/// A point of scene space in world space.
Vector3 world_from_scene(const volumes::VolumeInfo& info, const Vector3& point);
/// Length of the longest edge of the volume in world units: what a length of 1 in scene space is.
double world_size(const volumes::VolumeInfo& info);

}  // namespace cvr::gpu
