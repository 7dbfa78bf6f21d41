#include "volumes/generators/noise.hpp"

#include <algorithm>

#include "volumes/generators/random.hpp"

namespace cvr::volumes {

ValueNoise::ValueNoise(std::uint64_t seed, const std::array<std::uint32_t, 3>& spacing)
    : seed_(seed) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    spacing_[axis] = spacing[axis];
    for (std::uint32_t i = 0; i < spacing[axis]; ++i) {
      const float t = static_cast<float>(i) / static_cast<float>(spacing[axis]);
      fade_[axis].push_back(t * t * (3.0F - 2.0F * t));
    }
  }
}

float ValueNoise::column(std::int64_t x, std::int64_t y, std::int64_t z, float fade_y,
                         float fade_z) const {
  const auto corner = [&](std::int64_t dy, std::int64_t dz) {
    return 2.0F * unit_float(hash(seed_, x, y + dy, z + dz)) - 1.0F;
  };
  const float near00 = corner(0, 0), near10 = corner(1, 0);
  const float far00 = corner(0, 1), far10 = corner(1, 1);
  const float low = near00 + fade_y * (near10 - near00);
  const float high = far00 + fade_y * (far10 - far00);
  return low + fade_z * (high - low);
}

void ValueNoise::add_row(std::int64_t x0, std::size_t count, std::int64_t y, std::int64_t z,
                         float amplitude, float* out) const {
  const std::int64_t ly = floor_div(y, spacing_[1]), lz = floor_div(z, spacing_[2]);
  const float fade_y = fade_[1][static_cast<std::size_t>(y - ly * spacing_[1])];
  const float fade_z = fade_[2][static_cast<std::size_t>(z - lz * spacing_[2])];
  const std::int64_t end = x0 + static_cast<std::int64_t>(count);
  std::int64_t lx = floor_div(x0, spacing_[0]);
  float left = column(lx, ly, lz, fade_y, fade_z);
  for (std::int64_t x = x0; x < end; ++lx) {
    const float right = column(lx + 1, ly, lz, fade_y, fade_z);
    const std::int64_t stop = std::min(end, (lx + 1) * spacing_[0]);
    const float* fade = fade_[0].data() + (x - lx * spacing_[0]);
    float* target = out + (x - x0);
    for (std::int64_t i = 0; i < stop - x; ++i)
      target[i] += amplitude * (left + fade[i] * (right - left));
    x = stop;
    left = right;
  }
}

}  // namespace cvr::volumes
