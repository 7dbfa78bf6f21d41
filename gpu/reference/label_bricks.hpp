// The label pyramid of a volume, and which labels each of its bricks holds.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "volumes/volume.hpp"

namespace cvr::gpu {

/// Numbers the labels of a volume 0, 1, ... in ascending order, so that tables by label stay small.
class LabelTable {
 public:
  LabelTable() = default;
  /// `labels` ascending, each once.
  explicit LabelTable(std::vector<std::uint64_t> labels);
  const std::vector<std::uint64_t>& labels() const { return labels_; }
  /// Of a label of the volume.
  std::uint32_t number_of(std::uint64_t label) const {
    return direct_.empty() ? hashed_.find(label)->second : direct_[label];
  }

 private:
  std::vector<std::uint64_t> labels_;
  std::vector<std::uint32_t> direct_;  ///< by label, where the largest one is small enough
  std::unordered_map<std::uint64_t, std::uint32_t> hashed_;
};

class LabelBricks {
 public:
  /// Levels 0 .. log2(brick) of a label volume, which outlives this. brick: a power of two.
  LabelBricks(const volumes::Volume& finest, std::uint32_t brick, unsigned threads);

  const volumes::VolumeInfo& info() const { return levels_.front()->info(); }
  std::uint32_t brick() const { return brick_; }
  unsigned levels() const { return static_cast<unsigned>(levels_.size()); }
  const volumes::Volume& level(unsigned level) const { return *levels_[level]; }
  const volumes::Extent& grid() const { return grid_; }
  const LabelTable& table() const { return table_; }
  /// The numbers of the labels of a brick at the finest level; the coarser levels hold no others.
  std::span<const std::uint32_t> numbers_in(std::uint64_t brick) const { return palettes_[brick]; }

 private:
  std::vector<volumes::Volume> coarser_;
  std::vector<const volumes::Volume*> levels_;
  std::uint32_t brick_;
  volumes::Extent grid_;
  LabelTable table_;
  std::vector<std::vector<std::uint32_t>> palettes_;
};

}  // namespace cvr::gpu
