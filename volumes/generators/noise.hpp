// Smooth value noise on the voxel grid: random values in [-1, 1) at lattice points some voxels
// apart, between them a product of cubic fades. Evaluated by rows; each value depends on its own
// position only, never on where the row starts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cvr::volumes {

class ValueNoise {
 public:
  /// Voxels between lattice points along x, y, z, each >= 1.
  ValueNoise(std::uint64_t seed, const std::array<std::uint32_t, 3>& spacing);
  ValueNoise(std::uint64_t seed, std::uint32_t spacing)
      : ValueNoise(seed, {spacing, spacing, spacing}) {}
  /// Adds amplitude * noise at (x0 + i, y, z) to out[i] for i < count. Coordinates may be negative.
  void add_row(std::int64_t x0, std::size_t count, std::int64_t y, std::int64_t z, float amplitude,
               float* out) const;

 private:
  float column(std::int64_t x, std::int64_t y, std::int64_t z, float fade_y, float fade_z) const;

  std::uint64_t seed_;
  std::array<std::int64_t, 3> spacing_;
  std::array<std::vector<float>, 3> fade_;
};

/// floor(a / b) for b > 0.
inline std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return (a >= 0 ? a : a - b + 1) / b;
}

}  // namespace cvr::volumes
