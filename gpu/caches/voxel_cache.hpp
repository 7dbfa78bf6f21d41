// The voxel cache of section 4.1 of the CSGV-R paper: a cuckoo table of single labels, optionally
// with empty-space bits (4.2).
#pragma once

#include "gpu/caches/cache.hpp"

namespace cvr::gpu {

class VoxelCache final : public Cache {
 public:
  /// The whole of setting.cache_bytes goes to the table; the empty-space bits, if any, are beside
  /// it.
  static volumes::Expected<std::unique_ptr<Cache>> make(const CacheSetting& setting,
                                                        bool empty_space);

  void extend_kernel(KernelSource& source) const override;
  void describe(FrameConstants& frame) const override;
  void clear(Commands& commands, bool everything) override;
  std::vector<MemoryUse> memory() const override;

 private:
  explicit VoxelCache(const CacheSetting& setting) : setting_(setting) {}
  volumes::Expected<void> make_empty_space();

  CacheSetting setting_;
  DeviceBuffer table_, bits_;
  std::uint32_t entries_ = 0, position_bits_ = 0;
  std::uint64_t bit_words_ = 0;
  std::vector<std::uint32_t>
      first_word_;  ///< of the bits of levels 1, 2, ...; empty: no empty-space bits
};

/// Empty if the encoding has access to single voxels.
std::string refuses_voxel_cache(const codecs::GpuEncoding& encoding, const DeviceLimits& limits);

}  // namespace cvr::gpu
