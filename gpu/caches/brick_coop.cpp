// `brick-coop`: the invocations of one subgroup decode one brick together, each its own cells where
// the codec has access to cells.
#include "gpu/caches/brick_cache.hpp"

namespace cvr::gpu {

CacheTraits cooperative_brick_cache() {
  return {
      .id = "brick-coop",
      .summary = "whole bricks, each decoded by one subgroup, a frame late",
      .sized = true,
      .placeholders = true,
      .refuses = [](const codecs::GpuEncoding& encoding,
                    const DeviceLimits& limits) -> std::string {
        if (encoding.together) return BrickCache::refuses_sweep(encoding, limits);
        return encoding.voxel_access
                   ? ""
                   : "the codec has neither access to single voxels nor a decoder for subgroups";
      },
      .make =
          [](const CacheSetting& setting) {
            return BrickCache::make(setting, BrickDecoding::kCooperative);
          }};
}

}  // namespace cvr::gpu
