// Where the edges of a scalar volume are: its voxels of steepest gradient.
//
// The gradient is that of central differences, in voxel values per voxel: the difference of the two
// neighbours on an axis over their distance, at a side of the volume (of a time step) of the voxel
// itself and its only neighbour, on an axis of one voxel 0. The edges are the 5 % of the voxels of
// largest gradient magnitude; voxels that equal the least of them (to 2^-10 of the squared
// magnitude) belong to them too, voxels without a gradient never do. Where a voxel that the
// differences need is not finite there is no gradient.
#pragma once

#include "volumes/source.hpp"

namespace cvr::volumes {

class EdgeVoxels {
 public:
  /// Scans the source once.
  EdgeVoxels(const VolumeSource& source, unsigned threads);
  /// Least squared gradient magnitude of an edge; infinity where no voxel is one.
  double threshold() const { return threshold_; }
  /// Readies the planes [z0, z1) for mark(): valid until the next call.
  void load(std::uint64_t z0, std::uint64_t z1);
  /// edges[x + X y] = 1 where the voxel (x, y) of the loaded plane z is an edge, else 0. For
  /// several threads at once.
  void mark(std::uint64_t z, std::uint8_t* edges) const;

 private:
  /// Calls take(index in the plane, squared magnitude) for each voxel of a loaded plane that has a
  /// gradient.
  template <class Take>
  void each_gradient(std::uint64_t z, Take&& take) const;

  const VolumeInfo info_;
  SlabReader reader_;
  const std::byte* planes_ = nullptr;
  std::uint64_t first_plane_ = 0;
  double threshold_;
};

}  // namespace cvr::volumes
