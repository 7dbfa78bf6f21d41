// Random volumes for property tests. Sizes follow RapidCheck's size, so that failures shrink to small
// volumes.
#pragma once

#include <rapidcheck.h>

#include "tests/zoo/zoo.hpp"

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
  return zoo::make_labels(info, [=](const volumes::Coordinate& c) {
    const std::uint64_t label =
        zoo::random_at(seed, (c.x / cell) + ((c.y / cell) << 16) + ((c.z / cell) << 32)) % labels;
    return anywhere ? zoo::random_at(seed + 1, label) : label;
  });
}

}  // namespace cvr::property
