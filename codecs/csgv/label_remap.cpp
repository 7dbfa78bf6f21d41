// Where all labels differ, the table is larger than the caches, and look-ups wait for memory. So they
// go in batches: a first pass asks for buckets, a second finds them in the cache.
#include "codecs/csgv/label_remap.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "codecs/label_codes.hpp"
#include "volumes/error.hpp"
#include "volumes/slabs.hpp"

namespace cvr::codecs::csgv {

namespace {

constexpr std::size_t kBatch = 256;  ///< voxels

/// Whether a label needs more than 32 bits.
bool any_is_wide(std::span<const std::uint64_t> voxels) {
  constexpr std::size_t kAtOnce = 4096;
  for (std::size_t i = 0; i < voxels.size(); i += kAtOnce) {
    std::uint64_t all_bits = 0;
    for (const std::uint64_t label : voxels.subspan(i, std::min(kAtOnce, voxels.size() - i)))
      all_bits |= label;
    if (all_bits >> 32 != 0) return true;
  }
  return false;
}

}  // namespace

std::vector<std::uint64_t> distinct_labels(const volumes::VolumeSource& source, unsigned threads) {
  DistinctLabels distinct(threads);
  volumes::for_each_slab(source, kSlabDepth, [&](std::uint64_t, std::span<const std::byte> slab) {
    distinct.add(source.info().type, slab);
  });
  return distinct.take();
}

LabelRemap::LabelRemap(const volumes::VolumeSource& source, unsigned threads) {
  if (source.info().type != volumes::VoxelType::kU64) return;
  bool wide = false;
  volumes::for_each_slab(source, kSlabDepth, [&](std::uint64_t, std::span<const std::byte> slab) {
    wide = any_is_wide(volumes::values_of<std::uint64_t>(slab));
    return !wide;
  });
  if (!wide) return;
  labels_ = distinct_labels(source, threads);
  fill_buckets();
}

void LabelRemap::fill_buckets() {
  constexpr std::size_t kMost = 3;  // places taken of a bucket, on average
  buckets_.resize(std::bit_ceil((labels_.size() + kMost - 1) / kMost));
  std::array<std::size_t, kBatch> own;
  for (std::size_t first = 0; first < labels_.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, labels_.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      own[k] = bucket_of(labels_[first + k]);
      __builtin_prefetch(&buckets_[own[k]], 1);
    }
    for (std::size_t k = 0; k < count; ++k) {
      std::size_t at = own[k];
      while (buckets_[at].taken == Bucket::kPlaces) at = (at + 1) & (buckets_.size() - 1);
      Bucket& bucket = buckets_[at];
      bucket.labels[bucket.taken] = labels_[first + k];
      bucket.ranks[bucket.taken++] = static_cast<std::uint32_t>(first + k + 1);
    }
  }
}

/// The rank of a label that has this bucket or, if that is full, one behind it.
inline std::uint32_t LabelRemap::rank_in(std::size_t at, std::uint64_t label) const {
  for (;; at = (at + 1) & (buckets_.size() - 1)) {
    const Bucket& bucket = buckets_[at];
    std::uint32_t found = 0;
    for (std::size_t i = 0; i < Bucket::kPlaces; ++i)
      found |= bucket.ranks[i] & (0u - static_cast<std::uint32_t>(bucket.labels[i] == label));
    if (found != 0) return found - 1;
    if (bucket.taken < Bucket::kPlaces)
      throw volumes::InputError("the volume has changed between two readings: a new label");
  }
}

/// The ranks of at most kBatch voxels.
void LabelRemap::rank(std::span<const std::uint64_t> voxels, std::uint32_t* out) const {
  struct Run {
    std::uint32_t begin, bucket;
  };
  std::array<Run, kBatch> runs;  ///< of the same label
  std::size_t count = 0;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    if (i > 0 && voxels[i] == voxels[i - 1]) continue;
    const std::size_t bucket = bucket_of(voxels[i]);
    __builtin_prefetch(&buckets_[bucket]);
    runs[count++] = {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(bucket)};
  }
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t begin = runs[k].begin;
    const std::size_t end = k + 1 < count ? runs[k + 1].begin : voxels.size();
    const std::uint32_t rank = rank_in(runs[k].bucket, voxels[begin]);
    for (std::size_t i = begin; i < end; ++i) out[i] = rank;
  }
}

void LabelRemap::apply(std::span<const std::uint64_t> voxels, std::uint32_t* out) const {
  if (labels_.empty()) {
    std::ranges::transform(voxels, out,
                           [](std::uint64_t label) { return static_cast<std::uint32_t>(label); });
    return;
  }
  for (std::size_t i = 0; i < voxels.size(); i += kBatch)
    rank(voxels.subspan(i, std::min(kBatch, voxels.size() - i)), out + i);
}

}  // namespace cvr::codecs::csgv
