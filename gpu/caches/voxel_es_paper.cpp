// `voxel-es-paper`: Algorithm 4 of the CSGV-R paper to the letter, to judge its claims by: a bit
// stands for a block of 2x2x2 voxels (4x4x4 and so on where an index of 32 bits tells no more) and is
// looked up whatever the level. A coarse node that is visible is passed over where the block at its
// corner is empty and was marked at a finer level, so images have wrong pixels once the camera moves.
#include "gpu/caches/voxel_cache.hpp"

namespace cvr::gpu {

CacheTraits voxel_cache_of_the_paper() {
  return {.id = "voxel-es-paper",
          .summary = "a cuckoo table of single labels, and empty-space bits as published",
          .sized = true,
          .placeholders = false,
          .exact = false,
          .refuses = refuses_voxel_cache,
          .make = [](const CacheSetting& setting) {
            return VoxelCache::make(setting, EmptySpace::kBlocks);
          }};
}

}  // namespace cvr::gpu
