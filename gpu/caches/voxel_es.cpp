// `voxel-es`: the table, and one bit for each 2x2x2 block or coarser node that is known to hold
// nothing visible.
#include "gpu/caches/voxel_cache.hpp"

namespace cvr::gpu {

CacheTraits voxel_cache_with_empty_space() {
  return {.id = "voxel-es",
          .summary = "a cuckoo table of single labels, and empty-space bits",
          .sized = true,
          .placeholders = false,
          .refuses = refuses_voxel_cache,
          .make = [](const CacheSetting& setting) {
            return VoxelCache::make(setting, EmptySpace::kNodes);
          }};
}

}  // namespace cvr::gpu
