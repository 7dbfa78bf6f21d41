// All access modes, in the order of the paper's tables.
#include <algorithm>

#include "gpu/caches/cache.hpp"

namespace cvr::gpu {

CacheTraits no_cache();
CacheTraits voxel_cache();
CacheTraits voxel_cache_with_empty_space();
CacheTraits voxel_cache_of_the_paper();
CacheTraits brick_cache();
CacheTraits cooperative_brick_cache();
CacheTraits cooperative_shared_brick_cache();
CacheTraits slice_ring();

std::span<const CacheTraits> all_caches() {
  static const CacheTraits kCaches[] = {no_cache(),
                                        voxel_cache(),
                                        voxel_cache_with_empty_space(),
                                        voxel_cache_of_the_paper(),
                                        brick_cache(),
                                        cooperative_brick_cache(),
                                        cooperative_shared_brick_cache(),
                                        slice_ring()};
  return kCaches;
}

const CacheTraits* find_cache(std::string_view id) {
  const auto all = all_caches();
  const auto found = std::ranges::find(all, id, &CacheTraits::id);
  return found == all.end() ? nullptr : &*found;
}

}  // namespace cvr::gpu
