// How the general-purpose codecs cut a volume into slabs: by a fixed number of bytes, so that the
// compressor is fed the same pieces whatever the source and the number of threads.
#pragma once

#include <algorithm>

#include "codecs/codec.hpp"

namespace cvr::codecs::general {

inline constexpr std::uint64_t kSlabBytes = std::uint64_t{16} << 20;

inline std::uint64_t plane_bytes(const VolumeInfo& info) {
  return info.extent.x * info.extent.y * size_of(info.type);
}

/// Calls feed(span of the slab's bytes, is_last) for each slab; stops at the first error.
template <class Feed>
Expected<void> for_each_slab(const VolumeSource& source, Feed&& feed) {
  const VolumeInfo& info = source.info();
  const std::uint64_t plane = plane_bytes(info);
  const std::uint64_t depth = std::max<std::uint64_t>(1, kSlabBytes / plane);
  volumes::SlabReader reader(source);
  for (std::uint64_t z0 = 0; z0 < info.extent.z; z0 += depth) {
    const std::uint64_t z1 = std::min(z0 + depth, info.extent.z);
    const std::byte* voxels = reader.read(z0, z1);
    Expected<void> fed = feed(std::span(voxels, (z1 - z0) * plane), z1 == info.extent.z);
    if (!fed) return fed;
  }
  return {};
}

/// Calls fill(span of the slab's bytes) for each slab of the sink; stops at the first error.
template <class Fill>
Expected<void> fill_slabs(const VolumeInfo& info, SlabSink& sink, Fill&& fill) {
  const std::uint64_t plane = plane_bytes(info);
  const std::uint64_t depth = std::max<std::uint64_t>(1, sink.preferred_depth());
  for (std::uint64_t z0 = 0; z0 < info.extent.z; z0 += std::min(depth, info.extent.z - z0)) {
    const std::uint64_t z1 = z0 + std::min(depth, info.extent.z - z0);
    std::byte* out = sink.begin(z0, z1);
    Expected<void> filled = fill(std::span(out, (z1 - z0) * plane));
    if (!filled) return filled;
    sink.end(z0, z1);
  }
  return {};
}

}  // namespace cvr::codecs::general
