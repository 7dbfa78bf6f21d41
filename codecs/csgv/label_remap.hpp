// How the codecs of the CSGV families store labels above 32 bits: as their ranks among all labels.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volumes/huge_pages.hpp"
#include "volumes/label_hash.hpp"
#include "volumes/source.hpp"

namespace cvr::codecs::csgv {

/// Slabs that whole passes over a volume read, in voxels along z.
inline constexpr std::uint64_t kSlabDepth = 64;

/// All labels of a volume, ascending.
std::vector<std::uint64_t> distinct_labels(const volumes::VolumeSource& source, unsigned threads);

class LabelRemap {
 public:
  /// Reads the whole volume once, and a second time if a label needs more than 32 bits.
  LabelRemap(const volumes::VolumeSource& source, unsigned threads);

  /// All labels, ascending; empty where they are stored as they are.
  const std::vector<std::uint64_t>& labels() const { return labels_; }

  /// Narrows labels to the stored 32 bits. Throws InputError where a label is none of labels().
  void apply(std::span<const std::uint64_t> voxels, std::uint32_t* out) const;

 private:
  /// Some labels of one hash and their ranks + 1; a line of the cache. 0 where a place is free, the
  /// last ones first: what does not find room goes to the next bucket.
  struct alignas(64) Bucket {
    static constexpr std::size_t kPlaces = 5;
    std::array<std::uint64_t, kPlaces> labels{};
    std::array<std::uint32_t, kPlaces> ranks{};
    std::uint32_t taken = 0;
  };

  void fill_buckets();
  std::size_t bucket_of(std::uint64_t label) const {
    return volumes::hash_of(label) & (buckets_.size() - 1);
  }
  std::uint32_t rank_in(std::size_t bucket, std::uint64_t label) const;
  void rank(std::span<const std::uint64_t> voxels, std::uint32_t* out) const;

  std::vector<std::uint64_t> labels_;
  /// A power of two, at most 3 of 5 places taken: few labels miss their own bucket.
  std::vector<Bucket, volumes::HugePages<Bucket>> buckets_;
};

}  // namespace cvr::codecs::csgv
