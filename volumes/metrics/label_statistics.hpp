// Voxels and bounding box of every label, from whatever parts a volume comes in: runs along x, boxes
// of one label, boxes of voxels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "volumes/volume.hpp"

namespace cvr::volumes {

struct LabelStatistics {
  std::uint64_t label = 0;
  std::uint64_t voxels = 0;
  Coordinate first, last;  ///< of the bounding box, both included
  bool operator==(const LabelStatistics&) const = default;
};

/// Counts the labels of parts that do not overlap, in any order.
class LabelCounter {
 public:
  /// A box of voxels that all have this label; not empty.
  void add_uniform(const Box& box, std::uint64_t label);
  /// A box of voxels, x fastest, without gaps, in a type that labels may have.
  void add_voxels(const Box& box, const std::byte* voxels, VoxelType type);
  /// What another has counted of other parts.
  void merge(const LabelCounter& other);
  /// All labels, ascending.
  std::vector<LabelStatistics> result() const;

 private:
  LabelStatistics& entry(std::uint64_t label);
  void grow();
  template <class T>
  void add_rows(const Box& box, const T* voxels);

  /// Open addressing by label_hash.hpp; a slot without voxels is free. A power of two.
  std::vector<LabelStatistics> slots_ = std::vector<LabelStatistics>(64);
  std::size_t used_ = 0;
};

}  // namespace cvr::volumes
