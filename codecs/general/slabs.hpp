// How the general-purpose codecs cut a volume into slabs: by a fixed number of bytes, so that the
// compressor is fed the same pieces whatever the source and the number of threads.
#pragma once

#include <algorithm>

#include "codecs/codec.hpp"
#include "volumes/slabs.hpp"

namespace cvr::codecs::general {

inline constexpr std::uint64_t kSlabBytes = std::uint64_t{16} << 20;

/// Calls feed(span of the slab's bytes, is_last) for each slab; stops at the first error.
template <class Feed>
Expected<void> feed_slabs(const VolumeSource& source, Feed&& feed) {
  const VolumeInfo& info = source.info();
  const std::uint64_t plane = volumes::plane_bytes(info);
  Expected<void> fed;
  volumes::for_each_slab(source, volumes::planes_within(kSlabBytes, info),
                         [&](std::uint64_t z0, std::span<const std::byte> voxels) {
                           const bool last = z0 + voxels.size() / plane == info.extent.z;
                           fed = feed(voxels, last);
                           return fed.has_value();
                         });
  return fed;
}

/// Calls fill(span of the slab's bytes) for each slab of the sink; stops at the first error.
template <class Fill>
Expected<void> fill_slabs(const VolumeInfo& info, SlabSink& sink, Fill&& fill) {
  const std::uint64_t plane = volumes::plane_bytes(info);
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
