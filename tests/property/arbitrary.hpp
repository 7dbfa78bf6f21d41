// Random volumes for property tests. Sizes follow RapidCheck's size, so that failures shrink to
// small volumes.
#pragma once

#include <rapidcheck.h>

#include <cmath>

#include "tests/samples/sample_volumes.hpp"

namespace cvr::property {

/// Sides of 1..limit, not alike.
inline volumes::Extent arbitrary_extent(std::uint64_t limit) {
  const auto side = [&] { return *rc::gen::inRange<std::uint64_t>(1, limit + 1); };
  return {side(), side(), side()};
}

/// Few or many labels, in runs or as noise, small or anywhere in the range of the type.
inline volumes::Volume arbitrary_labels(volumes::VoxelType type, const volumes::Extent& extent) {
  const volumes::VolumeInfo info{.extent = extent, .type = type, .voxel_unit = {}};
  const auto seed = *rc::gen::inRange<std::uint64_t>(0, 1u << 20);
  const auto labels = *rc::gen::element<std::uint64_t>(1, 2, 3, 17, 300, 1u << 20);
  const auto cell = *rc::gen::element<std::uint64_t>(1, 1, 2, 3, 5, 8);
  const bool anywhere = *rc::gen::arbitrary<bool>();
  return samples::make_labels(info, [=](const volumes::Coordinate& c) {
    const std::uint64_t label =
        samples::random_at(seed, (c.x / cell) + ((c.y / cell) << 16) + ((c.z / cell) << 32)) %
        labels;
    return anywhere ? samples::random_at(seed + 1, label) : label;
  });
}

/// Smooth, rough or full of jumps; narrow or over the range of the type, of f32 over 2^-40 to 2^40;
/// half of the time a series.
inline volumes::Volume arbitrary_scalars(volumes::VoxelType type, const volumes::Extent& extent) {
  volumes::Volume volume(
      {.extent = extent, .type = type, .kind = volumes::VolumeKind::kScalars, .voxel_unit = {}});
  const auto seed = *rc::gen::inRange<std::uint64_t>(0, 1u << 20);
  const auto cell = *rc::gen::element<std::uint64_t>(1, 1, 3, 8);
  const auto narrow = *rc::gen::inRange(0, 12);
  const auto exponent = *rc::gen::inRange(-40, 41);
  volumes::with_voxel_type(type, [&]<class T>() {
    const auto voxels = volume.voxels<T>();
    for (std::uint64_t i = 0; i < voxels.size(); ++i) {
      const std::uint64_t x = i % extent.x, y = i / extent.x % extent.y,
                          z = i / (extent.x * extent.y);
      const std::uint64_t random =
          samples::random_at(seed, (x / cell) + ((y / cell) << 16) + ((z / cell) << 32)) >>
          (40 + narrow);
      if constexpr (std::is_floating_point_v<T>) {
        voxels[i] = std::ldexp(static_cast<float>(random) - 2e3f, exponent);
      } else {
        voxels[i] = static_cast<T>(random + x + 2 * y);
      }
    }
  });
  if (*rc::gen::arbitrary<bool>()) {
    std::uint64_t steps = *rc::gen::inRange<std::uint64_t>(1, extent.z + 1);
    while (extent.z % steps != 0) --steps;
    volume.info().time_steps = steps;
  }
  return volume;
}

}  // namespace cvr::property
