#include "experiments/error_sink.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cvr::experiments {

using volumes::VoxelType;

std::byte* ErrorSink::begin(std::uint64_t z0, std::uint64_t z1) {
  const volumes::VolumeInfo& info = truth_.info();
  slab_.resize((z1 - z0) * info.extent.x * info.extent.y * size_of(info.type));
  return slab_.data();
}

void ErrorSink::end(std::uint64_t z0, std::uint64_t z1) {
  const volumes::VolumeInfo& info = truth_.info();
  const std::byte* truth = reader_.read(z0, z1);
  const std::uint64_t count = (z1 - z0) * info.extent.x * info.extent.y;
  volumes::with_voxel_type(info.type, [&]<class T>() {
    for (std::uint64_t i = 0; i < count; ++i) {
      T a, b;
      std::memcpy(&a, truth + i * sizeof(T), sizeof(T));
      std::memcpy(&b, slab_.data() + i * sizeof(T), sizeof(T));
      mismatches_ += std::memcmp(&a, &b, sizeof(T)) != 0 ? 1 : 0;
      if (info.kind == volumes::VolumeKind::kLabels) continue;
      const auto value = static_cast<double>(a);
      const double error = std::abs(value - static_cast<double>(b));
      largest_error_ = std::max(largest_error_, error);
      squared_sum_ += error * error;
      minimum_ = compared_ + i == 0 ? value : std::min(minimum_, value);
      maximum_ = compared_ + i == 0 ? value : std::max(maximum_, value);
    }
  });
  compared_ += count;
}

double ErrorSink::mean_squared_error() const {
  return compared_ == 0 ? 0 : squared_sum_ / static_cast<double>(compared_);
}

std::optional<double> ErrorSink::psnr() const {
  const double peak = truth_.info().type == VoxelType::kU8 ? 255 : maximum_ - minimum_;
  const double mse = mean_squared_error();
  if (mse == 0 || peak <= 0 || !std::isfinite(mse)) return std::nullopt;
  return 10 * std::log10(peak * peak / mse);
}

}  // namespace cvr::experiments
