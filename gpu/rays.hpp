// A camera as the integers that the kernels' rays are made of (IMAGE.md, Precision).
#pragma once

#include <array>
#include <cstdint>

#include "gpu/scene.hpp"
#include "volumes/volume.hpp"

namespace cvr::gpu {

struct IntegerCamera {
  std::array<std::int64_t, 3> eye;  ///< 2^-20 voxels, at most 2^22 voxels away
  std::array<std::int64_t, 3>
      towards;  ///< 2^-16 direction units; the largest component of the corner rays is 2^30 units
  std::array<std::int64_t, 3> right, down;  ///< half a pixel
};

IntegerCamera integer_camera(const volumes::VolumeInfo& info, const Camera& camera,
                             std::uint32_t width, std::uint32_t height);

/// A direction scaled so that its largest component is 2^30.
std::array<std::int64_t, 3> integer_direction(const Vector3& direction);

}  // namespace cvr::gpu
