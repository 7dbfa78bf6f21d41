// `voxel`: the table alone; and what both voxel modes share.
#include <algorithm>
#include <bit>
#include <string>

#include "gpu/caches/voxel_cache.hpp"

namespace cvr::gpu {

namespace {

constexpr std::uint64_t kMostBlocks = std::uint64_t{1} << 32;  ///< that an index of 32 bits tells

}  // namespace

volumes::Expected<std::unique_ptr<Cache>> VoxelCache::make(const CacheSetting& setting,
                                                           EmptySpace empty_space) {
  std::unique_ptr<VoxelCache> cache(new VoxelCache(setting, empty_space));
  const std::uint64_t entries = setting.cache_bytes / 8;
  if (entries >= std::uint64_t{1} << 32) {
    return volumes::fail(volumes::ErrorCode::kUnsupported,
                         "voxel cache: positions have 32 bits, so at most 32 GiB");
  }
  cache->entries_ = static_cast<std::uint32_t>(entries);
  cache->position_bits_ = static_cast<std::uint32_t>(std::bit_width(entries - 1));
  auto table = DeviceBuffer::make(setting.device, entries * 8, "voxel cache");
  if (!table) return tl::unexpected(table.error());
  cache->table_ = std::move(*table);
  if (empty_space != EmptySpace::kNone) {
    if (auto ok = cache->make_empty_space(); !ok) return tl::unexpected(ok.error());
  }
  return cache;
}

volumes::Expected<void> VoxelCache::make_empty_space() {
  const auto words_of = [&](unsigned shift) {
    return (volumes::ceil_div(setting_.info.extent, std::uint64_t{1} << shift).voxels() + 31) / 32;
  };
  if (empty_space_ == EmptySpace::kBlocks) {
    while (words_of(block_shift_) > kMostBlocks / 32) ++block_shift_;
    bit_words_ = words_of(block_shift_);
  } else {
    for (unsigned level = 1; level < std::max(2u, setting_.encoding.levels); ++level) {
      first_word_.push_back(static_cast<std::uint32_t>(bit_words_));
      bit_words_ += words_of(level);
    }
  }
  auto bits = DeviceBuffer::make(setting_.device, bit_words_ * 4, "empty-space bits");
  if (!bits) return tl::unexpected(bits.error());
  bits_ = std::move(*bits);
  return {};
}

void VoxelCache::extend_kernel(KernelSource& source) const {
  if (empty_space_ != EmptySpace::kNone) source.definitions.emplace_back("CVR_EMPTY_SPACE", "1");
  if (empty_space_ == EmptySpace::kBlocks)
    source.definitions.emplace_back("CVR_EMPTY_BLOCK_SHIFT", std::to_string(block_shift_) + "u");
  append_source(source, setting_.decoder);
  source.files.emplace_back("shaders/caches/voxel.glsl");
}

void VoxelCache::describe(FrameConstants& frame) const {
  frame.cache[0] = table_.address();
  frame.cache[1] = bits_.address();
  frame.cache_sizes[0] = entries_;
  frame.cache_sizes[1] = position_bits_;
  std::ranges::copy(first_word_, frame.cache_sizes + 2);
}

void VoxelCache::clear(Commands& commands, bool everything) {
  if (everything) commands.fill(table_, 0, table_.bytes(), 0xffffffff);
  if (bit_words_ > 0) commands.fill(bits_, 0, bits_.bytes(), 0);
}

std::vector<MemoryUse> VoxelCache::memory() const {
  std::vector<MemoryUse> uses{{"cache", table_.bytes()}};
  if (bit_words_ > 0) uses.push_back({"empty-space bits", bits_.bytes()});
  return uses;
}

std::string refuses_voxel_cache(const codecs::GpuEncoding& encoding, const DeviceLimits&) {
  return encoding.voxel_access ? std::string()
                               : "the codec decodes whole bricks, not single voxels";
}

CacheTraits voxel_cache() {
  return {.id = "voxel",
          .summary = "a cuckoo table of single labels",
          .sized = true,
          .placeholders = false,
          .refuses = refuses_voxel_cache,
          .make = [](const CacheSetting& setting) {
            return VoxelCache::make(setting, EmptySpace::kNone);
          }};
}

}  // namespace cvr::gpu
