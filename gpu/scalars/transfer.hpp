// Transfer functions: colour and density of a scalar, as a table over the value range of a volume.
#pragma once

#include <array>
#include <vector>

#include "gpu/scene.hpp"

namespace cvr::gpu {

inline constexpr std::size_t kTransferEntries = 256;
/// Slope, as a part of the value range a world unit, from which shading is full: flat regions have
/// no normal, only rounding.
inline constexpr double kShadingKnee = 1.0 / 1024;

/// Values that the ends of a transfer function mean: 0..255 for u8, else least and largest finite
/// value of the volume.
struct ValueRange {
  double least = 0, largest = 1;
};

/// Red, green, blue (0..1, linear) and density a world unit.
using TransferEntry = std::array<double, 4>;

/// Entries at equal steps of the range, both ends included; between points linear, beyond the outer
/// points constant.
std::vector<TransferEntry> transfer_table(const std::vector<TransferPoint>& points);

/// What the axis of the slices is for a camera, and the order in which the view meets them.
struct SliceOrder {
  std::size_t axis;  ///< 0 x, 1 y, 2 z: along which the view direction is longest, in voxels
  bool backwards;    ///< the last slice comes first
};
SliceOrder slice_order(const volumes::VolumeInfo& info, const Camera& camera);

}  // namespace cvr::gpu
