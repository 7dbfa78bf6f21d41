// The voxel cache of section 4.1 of the CSGV-R paper: a cuckoo table of single labels, optionally
// with empty-space bits (4.2).
#pragma once

#include "gpu/caches/cache.hpp"

namespace cvr::gpu {

/// What a bit stands for that says that nothing is visible.
enum class EmptySpace {
  kNone,    ///< there are none
  kNodes,   ///< a block of 2x2x2 voxels at levels 0 and 1, a node at coarser ones
  kBlocks,  ///< a block of voxels, whatever the level: Algorithm 4 to the letter
};

class VoxelCache final : public Cache {
 public:
  /// The whole of setting.cache_bytes goes to the table; the empty-space bits, if any, are beside
  /// it.
  static volumes::Expected<std::unique_ptr<Cache>> make(const CacheSetting& setting,
                                                        EmptySpace empty_space);

  void extend_kernel(KernelSource& source) const override;
  void describe(FrameConstants& frame) const override;
  void clear(Commands& commands, bool everything) override;
  std::vector<MemoryUse> memory() const override;

 private:
  VoxelCache(const CacheSetting& setting, EmptySpace empty_space)
      : setting_(setting), empty_space_(empty_space) {}
  volumes::Expected<void> make_empty_space();

  CacheSetting setting_;
  EmptySpace empty_space_ = EmptySpace::kNone;
  DeviceBuffer table_, bits_;
  std::uint32_t entries_ = 0, position_bits_ = 0;
  std::uint64_t bit_words_ = 0;
  std::vector<std::uint32_t> first_word_;  ///< kNodes: of the bits of levels 1, 2, ...
  std::uint32_t block_shift_ = 1;          ///< kBlocks: log2 of a block's edge
};

/// Empty if the encoding has access to single voxels.
std::string refuses_voxel_cache(const codecs::GpuEncoding& encoding, const DeviceLimits& limits);

}  // namespace cvr::gpu
