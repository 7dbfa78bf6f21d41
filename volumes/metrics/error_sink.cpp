#include "volumes/metrics/error_sink.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "volumes/parallel.hpp"

namespace cvr::volumes {

ErrorSink::ErrorSink(const VolumeSource& truth, unsigned threads)
    : truth_(truth),
      threads_(std::max(threads, 1u)),
      reader_(truth),
      steps_(truth.info().time_steps) {
  if (truth.info().kind == VolumeKind::kScalars) edges_.emplace(truth, threads_);
  if (truth.info().type == VoxelType::kF32) relative_.resize(threads_);
}

std::byte* ErrorSink::begin(std::uint64_t z0, std::uint64_t z1) {
  const VolumeInfo& info = truth_.info();
  slab_.resize((z1 - z0) * info.extent.x * info.extent.y * size_of(info.type));
  return slab_.data();
}

void ErrorSink::end(std::uint64_t z0, std::uint64_t z1) {
  const VolumeInfo& info = truth_.info();
  const std::byte* truth = reader_.read(z0, z1);
  const std::uint64_t plane = info.extent.x * info.extent.y;
  const std::size_t voxel = size_of(info.type);
  compared_ += (z1 - z0) * plane;
  for (std::uint64_t i = 0; i < (z1 - z0) * plane * voxel; i += voxel)
    mismatches_ += std::memcmp(truth + i, slab_.data() + i, voxel) != 0 ? 1 : 0;
  if (info.kind == VolumeKind::kLabels) return;
  edges_->load(z0, z1);
  std::vector<Sums> planes(z1 - z0);
  std::vector<std::vector<std::uint8_t>> marks(threads_);
  parallel_for(threads_, z1 - z0, [&](unsigned worker, std::uint64_t z) {
    marks[worker].resize(plane);
    edges_->mark(z0 + z, marks[worker].data());
    with_voxel_type(info.type, [&]<class T>() {
      planes[z] = errors_of_plane<T>(truth + z * plane * voxel, slab_.data() + z * plane * voxel,
                                     marks[worker].data(),
                                     relative_.empty() ? nullptr : &relative_[worker]);
    });
  });
  for (std::uint64_t z = z0; z < z1; ++z) {
    sums_.add(planes[z - z0]);
    steps_[z / info.step_extent().z].add(planes[z - z0]);
  }
}

std::uint64_t ErrorSink::worst_step() const {
  const auto error = [](const Sums& step) { return mean(step.squared, step.voxels); };
  return static_cast<std::uint64_t>(std::ranges::max_element(steps_, {}, error) - steps_.begin());
}

std::optional<double> ErrorSink::worst_step_psnr() const {
  const Sums& worst = steps_[worst_step()];
  return psnr_of(mean(worst.squared, worst.voxels));
}

template <class T>
ErrorSink::Sums ErrorSink::errors_of_plane(const std::byte* truth, const std::byte* decoded,
                                           const std::uint8_t* edges, Magnitudes* relative) const {
  Sums sums;
  const std::uint64_t count = truth_.info().extent.x * truth_.info().extent.y;
  for (std::uint64_t i = 0; i < count; ++i) {
    T a, b;
    std::memcpy(&a, truth + i * sizeof(T), sizeof(T));
    std::memcpy(&b, decoded + i * sizeof(T), sizeof(T));
    const auto value = static_cast<double>(a);
    if (!std::isfinite(value)) continue;
    const double difference = std::abs(value - static_cast<double>(b));
    const double error =
        std::isnan(difference) ? std::numeric_limits<double>::infinity() : difference;
    sums.minimum = sums.voxels == 0 ? value : std::min(sums.minimum, value);
    sums.maximum = sums.voxels == 0 ? value : std::max(sums.maximum, value);
    ++sums.voxels;
    sums.largest = std::max(sums.largest, error);
    sums.squared += error * error;
    sums.absolute += error;
    if (edges[i] != 0) {
      ++sums.edges;
      sums.edge_squared += error * error;
    }
    if (relative != nullptr && value != 0) relative->add(error / std::abs(value));
  }
  return sums;
}

void ErrorSink::Sums::add(const Sums& other) {
  if (other.voxels == 0) return;
  minimum = voxels == 0 ? other.minimum : std::min(minimum, other.minimum);
  maximum = voxels == 0 ? other.maximum : std::max(maximum, other.maximum);
  voxels += other.voxels;
  edges += other.edges;
  largest = std::max(largest, other.largest);
  squared += other.squared;
  absolute += other.absolute;
  edge_squared += other.edge_squared;
}

std::optional<double> ErrorSink::edge_mean_squared_error() const {
  if (sums_.edges == 0) return std::nullopt;
  return mean(sums_.edge_squared, sums_.edges);
}

std::optional<double> ErrorSink::psnr_of(double mean_squared_error) const {
  const double peak = truth_.info().type == VoxelType::kU8 ? 255 : sums_.maximum - sums_.minimum;
  if (mean_squared_error == 0 || peak <= 0 || !std::isfinite(mean_squared_error))
    return std::nullopt;
  return 10 * std::log10(peak * peak / mean_squared_error);
}

std::optional<double> ErrorSink::edge_psnr() const {
  const auto error = edge_mean_squared_error();
  return error ? psnr_of(*error) : std::nullopt;
}

std::optional<double> ErrorSink::relative_error(double share) const {
  if (relative_.empty()) return std::nullopt;
  Magnitudes all = relative_[0];
  for (std::size_t i = 1; i < relative_.size(); ++i) all.add(relative_[i]);
  if (all.total() == 0) return std::nullopt;
  const double rank = std::ceil(share * static_cast<double>(all.total())) - 1;
  return all.at_rank(static_cast<std::uint64_t>(std::max(0.0, rank)));
}

}  // namespace cvr::volumes
