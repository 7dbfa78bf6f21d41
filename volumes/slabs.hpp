// Walks through a volume in slabs: whole planes, in ascending z.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <type_traits>

#include "volumes/source.hpp"

namespace cvr::volumes {

/// Bytes of one plane.
inline std::uint64_t plane_bytes(const VolumeInfo& info) {
  return info.extent.x * info.extent.y * size_of(info.type);
}

/// How many planes fit into so many bytes, at least one.
inline std::uint64_t planes_within(std::uint64_t bytes, const VolumeInfo& info) {
  return std::max<std::uint64_t>(1, bytes / plane_bytes(info));
}

/// Calls body(z0, bytes of the voxels) for each slab of `depth` >= 1 planes; the last has what is
/// left. A body that returns bool ends the walk by false.
template <class Body>
void for_each_slab(const VolumeSource& source, std::uint64_t depth, Body&& body) {
  const std::uint64_t end = source.info().extent.z, plane = plane_bytes(source.info());
  SlabReader reader(source);
  for (std::uint64_t z0 = 0, z1; z0 < end; z0 = z1) {
    z1 = z0 + std::min(depth, end - z0);
    const std::span voxels(reader.read(z0, z1), (z1 - z0) * plane);
    if constexpr (std::is_void_v<std::invoke_result_t<Body&, std::uint64_t, decltype(voxels)>>) {
      body(z0, voxels);
    } else if (!body(z0, voxels)) {
      return;
    }
  }
}

/// The bytes of voxels as values of their type.
template <class T>
std::span<const T> values_of(std::span<const std::byte> voxels) {
  return {reinterpret_cast<const T*>(voxels.data()), voxels.size() / sizeof(T)};
}

}  // namespace cvr::volumes
