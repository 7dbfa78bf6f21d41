// Volumes of a few voxels, scenes and rays for the tests of the reference renderer.
#pragma once

#include <cstdint>
#include <functional>

#include "gpu/reference/reference.hpp"

namespace cvr::gpu {

using LabelAt = std::function<std::uint64_t(std::uint64_t x, std::uint64_t y, std::uint64_t z)>;

inline volumes::Volume make_volume(const volumes::Extent& extent, const LabelAt& label,
                                   volumes::VoxelType type = volumes::VoxelType::kU8) {
  volumes::VolumeInfo info;
  info.extent = extent;
  info.type = type;
  volumes::Volume volume(info);
  volumes::with_label_type(type, [&]<class T>() {
    T* out = volume.voxels<T>().data();
    for (std::uint64_t z = 0; z < extent.z; ++z)
      for (std::uint64_t y = 0; y < extent.y; ++y)
        for (std::uint64_t x = 0; x < extent.x; ++x) *out++ = static_cast<T>(label(x, y, z));
  });
  return volume;
}

/// Label 0 is invisible, all others are white and opaque; the finest level everywhere.
inline Scene plain_scene() {
  Scene scene;
  scene.width = scene.height = 1;
  scene.materials = {{.first = 0, .last = 0, .opacity = 0}, {.colour = {{255, 255, 255}}}};
  scene.lod_bias = -40;
  return scene;
}

/// Looks at a point of voxel space from another; for volumes of cubic voxels.
inline Camera look(const volumes::VolumeInfo& info, const Vector3& eye, const Vector3& target,
                   const Vector3& up, double fov = 1e-3) {
  const double size = world_size(info);
  const auto scene_point = [&](const Vector3& p) {
    return Vector3{(p[0] - info.extent.x / 2.0) / size, (p[1] - info.extent.y / 2.0) / size,
                   (p[2] - info.extent.z / 2.0) / size};
  };
  return {scene_point(eye), scene_point(target), up, fov};
}

inline std::uint64_t hit(const ReferenceRenderer& renderer, const Vector3& origin,
                         const Vector3& direction, const Scene& scene = plain_scene()) {
  return renderer.trace(scene, Camera{}, {origin, direction});
}

}  // namespace cvr::gpu
