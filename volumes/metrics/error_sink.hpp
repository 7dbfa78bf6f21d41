// How much a decoded volume differs from the original, slab by slab.
//
// Labels: mismatching voxels. Scalars also, over the finite voxels of the original: largest and
// mean absolute error, mean squared error, the same over the edges (gradients.hpp), and PSNR = 10
// log10(peak^2 / MSE) with peak 255 for u8 and else the range of the original. PSNR has no value
// where the volumes are equal: `exact` says so instead. The range of f32 may be ruled by a few
// values, so errors relative to the voxel are there too. Of a series the worst time step is told
// too, by the same peak, since a mean hides one. Sums are made by planes, so that they do not
// depend on the number of threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "volumes/metrics/gradients.hpp"
#include "volumes/metrics/magnitudes.hpp"
#include "volumes/source.hpp"

namespace cvr::volumes {

class ErrorSink final : public SlabSink {
 public:
  /// Reads the truth twice where it holds scalars: its edges are found first.
  explicit ErrorSink(const VolumeSource& truth, unsigned threads = 1);
  std::uint64_t preferred_depth() const override { return 64; }
  std::byte* begin(std::uint64_t z0, std::uint64_t z1) override;
  void end(std::uint64_t z0, std::uint64_t z1) override;

  std::uint64_t compared() const { return compared_; }
  std::uint64_t mismatches() const { return mismatches_; }
  /// Voxels of the original that are NaN or infinite: compared, but in no error.
  std::uint64_t non_finite() const { return compared_ - sums_.voxels; }
  double largest_error() const { return sums_.largest; }
  double mean_squared_error() const { return mean(sums_.squared, sums_.voxels); }
  double mean_absolute_error() const { return mean(sums_.absolute, sums_.voxels); }
  std::uint64_t edge_voxels() const { return sums_.edges; }
  /// None where no voxel is an edge.
  std::optional<double> edge_mean_squared_error() const;
  std::optional<double> psnr() const { return psnr_of(mean_squared_error()); }
  std::optional<double> edge_psnr() const;
  std::uint64_t time_steps() const { return std::max<std::uint64_t>(steps_.size(), 1); }
  /// The time step of the largest mean squared error, of equals the first; of scalars.
  std::uint64_t worst_step() const;
  std::optional<double> worst_step_psnr() const;
  /// |error| / |voxel|, over the finite voxels that are not 0, that `share` of them do not exceed,
  /// to 2^-10; of f32 alone.
  std::optional<double> relative_error(double share) const;

 private:
  struct Sums {
    std::uint64_t voxels = 0, edges = 0;
    double largest = 0, squared = 0, absolute = 0, edge_squared = 0;
    double minimum = 0, maximum = 0;
    void add(const Sums& other);
  };
  static double mean(double sum, std::uint64_t count) {
    return count == 0 ? 0 : sum / static_cast<double>(count);
  }
  std::optional<double> psnr_of(double mean_squared_error) const;
  template <class T>
  Sums errors_of_plane(const std::byte* truth, const std::byte* decoded, const std::uint8_t* edges,
                       Magnitudes* relative) const;

  const VolumeSource& truth_;
  unsigned threads_;
  SlabReader reader_;
  std::optional<EdgeVoxels> edges_;
  std::vector<Magnitudes> relative_;  ///< one per thread
  Buffer slab_;
  std::uint64_t compared_ = 0, mismatches_ = 0;
  Sums sums_;
  std::vector<Sums> steps_;  ///< the same of each time step
};

}  // namespace cvr::volumes
