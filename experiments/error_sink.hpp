// How much a decoded volume differs from the original, slab by slab.
//
// Labels: mismatching voxels. Scalars also: largest absolute error, mean squared error, and PSNR = 10
// log10(peak^2 / MSE) with peak 255 for u8 and else the range of the original. PSNR has no value where the
// volumes are equal: `exact` says so instead.
#pragma once

#include <cstdint>
#include <optional>

#include "volumes/source.hpp"

namespace cvr::experiments {

class ErrorSink final : public volumes::SlabSink {
 public:
  explicit ErrorSink(const volumes::VolumeSource& truth) : truth_(truth), reader_(truth) {}
  std::uint64_t preferred_depth() const override { return 64; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override;
  void end(std::uint64_t z0, std::uint64_t z1) override;

  std::uint64_t compared() const { return compared_; }
  std::uint64_t mismatches() const { return mismatches_; }
  double largest_error() const { return largest_error_; }
  double mean_squared_error() const;
  std::optional<double> psnr() const;

 private:
  const volumes::VolumeSource& truth_;
  volumes::SlabReader reader_;
  volumes::Buffer slab_;
  std::uint64_t compared_ = 0, mismatches_ = 0;
  double squared_sum_ = 0, largest_error_ = 0;
  double minimum_ = 0, maximum_ = 0;
};

}  // namespace cvr::experiments
