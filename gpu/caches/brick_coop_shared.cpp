// `brick-coop-shared`: as brick-coop, from a copy of the brick's encoding (for CSGV-R its wavelet
// matrix) in shared memory.
#include <fmt/format.h>

#include "gpu/caches/brick_cache.hpp"

namespace cvr::gpu {

CacheTraits cooperative_shared_brick_cache() {
  return {
      .id = "brick-coop-shared",
      .summary = "as brick-coop, from a copy of the encoding in shared memory",
      .sized = true,
      .placeholders = true,
      .refuses = [](const codecs::GpuEncoding& encoding,
                    const DeviceLimits& limits) -> std::string {
        if (!encoding.voxel_access) return "the codec has no access to single voxels";
        if (encoding.shared_words == 0)
          return "the codec has no piece of encoding that belongs to one brick";
        const std::uint64_t bytes = std::uint64_t{encoding.shared_words} * 4;
        if (bytes <= limits.shared_memory) return "";
        return fmt::format(
            "the largest brick has {} bytes to copy, the device's maxComputeSharedMemorySize is {}",
            bytes, limits.shared_memory);
      },
      .make =
          [](const CacheSetting& setting) {
            return BrickCache::make(setting, BrickDecoding::kCooperativeShared);
          }};
}

}  // namespace cvr::gpu
