// Which labels a volume has, and the 32-bit codes that stand for them on a GPU.
//
// Segmented volumes repeat labels in runs and in neighbouring rows: a worker skips what equals the
// last label, then what its small direct-mapped cache has seen, and keeps the rest in a list that
// is sorted and thinned when it has doubled. Labels of one or two bytes have a mark each.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codecs/gpu_encoding.hpp"
#include "volumes/source.hpp"

namespace cvr::codecs {

class DistinctLabels {
 public:
  explicit DistinctLabels(unsigned threads) : workers_(threads == 0 ? 1 : threads) {}
  /// Adds labels; each worker is used by one thread at a time. T: u8, u16, u32, u64.
  template <class T>
  void add(unsigned worker, std::span<const T> labels);
  /// Adds labels with all workers; the voxels lie at a multiple of their size.
  void add(volumes::VoxelType type, std::span<const std::byte> voxels);
  /// All labels, ascending. Empties the set.
  std::vector<std::uint64_t> take();

 private:
  struct Worker {
    static constexpr std::size_t kCached = 4096;
    std::vector<std::uint64_t> cache;  ///< label seen last in each place
    std::vector<std::uint64_t> labels;
    std::vector<std::uint8_t> seen;  ///< of labels of one or two bytes, in place of the list
    std::size_t thinned = 0;         ///< labels after the last thinning
    void note(std::uint64_t label);
    void thin();
  };
  std::vector<Worker> workers_;
};

/// Throws the voxels away and keeps their labels.
class LabelSink final : public volumes::SlabSink {
 public:
  LabelSink(const volumes::VolumeInfo& info, DistinctLabels& labels)
      : info_(info), labels_(labels) {}
  std::uint64_t preferred_depth() const override { return 64; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override {
    slab_.resize((z1 - z0) * info_.extent.x * info_.extent.y * size_of(info_.type));
    return slab_.data();
  }
  void end(std::uint64_t, std::uint64_t) override { labels_.add(info_.type, slab_.bytes()); }

 private:
  volumes::VolumeInfo info_;
  DistinctLabels& labels_;
  volumes::Buffer slab_;
};

/// Sets codes and remap from all labels of a volume, ascending: the labels themselves if all fit in
/// 32 bits; else their places in the list, which becomes the next buffer ("remap"). Adds the
/// constant CVR_REMAP_SIZE, 0 without remap.
void assign_codes(const std::vector<std::uint64_t>& labels, GpuEncoding& encoding);

/// Whether texts without bricks of their own serve this brick edge: a power of two, 2..64.
bool is_brick_edge(std::uint32_t edge);

}  // namespace cvr::codecs
