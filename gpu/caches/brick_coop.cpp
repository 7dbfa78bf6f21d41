// `brick-coop`: the invocations of one subgroup decode one brick together, each its own cells.
#include "gpu/caches/brick_cache.hpp"

namespace cvr::gpu {

CacheTraits cooperative_brick_cache() {
  return {.id = "brick-coop",
          .summary = "whole bricks, each decoded by one subgroup, a frame late",
          .sized = true,
          .placeholders = true,
          .refuses = [](const codecs::GpuEncoding& encoding, const DeviceLimits&) {
            return encoding.voxel_access ? std::string() : "a serial stream has one reader: the codec has no access to single voxels";
          },
          .make = [](const CacheSetting& setting) { return BrickCache::make(setting, BrickDecoding::kCooperative); }};
}

}  // namespace cvr::gpu
