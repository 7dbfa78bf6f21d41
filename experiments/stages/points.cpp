#include "experiments/stages/points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

namespace cvr::experiments {

using volumes::Coordinate;
using volumes::Extent;
using volumes::VolumeSource;

namespace {

/// SplitMix64 (Steele, Lea, Flood 2014): small, seedable, the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t below(std::uint64_t n) {
    return static_cast<std::uint64_t>((static_cast<unsigned __int128>(next()) * n) >> 64);
  }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

constexpr std::uint64_t kLabelVoxels = 1 << 20;  // of the one label that are kept to draw from

/// A label, or the bits of a scalar.
std::uint64_t label_in(const volumes::VolumeInfo& info, const std::byte* voxels,
                       std::uint64_t index) {
  return volumes::with_voxel_type(info.type, [&]<class T>() -> std::uint64_t {
    std::uint64_t bits = 0;
    std::memcpy(&bits, voxels + index * sizeof(T), sizeof(T));
    return bits;
  });
}

std::uint64_t choose_label(const VolumeSource& source, std::uint64_t seed) {
  // A few hundred random voxels find a label that is not the background in any volume worth the
  // question.
  const auto candidates = uniform_points(source.info().extent, seed, 512);
  for (const std::uint64_t label : labels_at(source, candidates)) {
    if (label != 0) return label;
  }
  return 0;
}

}  // namespace

std::uint64_t points_a_series(double access_ns, double levels, bool by_bricks) {
  constexpr double kLeast = 1e5, kMost = 2e6, kRoundNs = 0.05e9;
  constexpr std::uint64_t kByBricks = 1000;
  if (by_bricks) return kByBricks;
  const double series = 3 * levels;
  return static_cast<std::uint64_t>(std::clamp(kRoundNs / (access_ns * series), kLeast, kMost));
}

std::vector<Coordinate> uniform_points(const Extent& extent, std::uint64_t seed,
                                       std::uint64_t count) {
  Random random(seed);
  std::vector<Coordinate> points(count);
  for (Coordinate& p : points) {
    p.x = random.below(extent.x);
    p.y = random.below(extent.y);
    p.z = random.below(extent.z);
  }
  return points;
}

std::vector<Coordinate> clustered_points(const Extent& extent, std::uint64_t seed,
                                         std::uint64_t count) {
  Random random(seed ^ 0x636c7573u);
  std::vector<Coordinate> points;
  points.reserve(count);
  const std::array<std::uint64_t, 3> axes{extent.x, extent.y, extent.z};
  while (points.size() < count) {
    std::array<double, 3> at{}, step{};
    double length = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      at[a] = static_cast<double>(random.below(axes[a])) + 0.5;
      step[a] = 2 * random.unit() - 1;
      length += step[a] * step[a];
    }
    if (length < 1e-6) continue;
    const double scale = 1 / std::sqrt(length);
    const auto inside = [&](std::size_t a) {
      return at[a] >= 0 && at[a] < static_cast<double>(axes[a]);
    };
    while (points.size() < count && inside(0) && inside(1) && inside(2)) {
      points.push_back({static_cast<std::uint64_t>(at[0]), static_cast<std::uint64_t>(at[1]),
                        static_cast<std::uint64_t>(at[2])});
      for (std::size_t a = 0; a < 3; ++a) at[a] += step[a] * scale;
    }
  }
  return points;
}

std::vector<Coordinate> one_label_points(const VolumeSource& source, std::uint64_t seed,
                                         std::uint64_t count) {
  const std::uint64_t label = choose_label(source, seed);
  const volumes::VolumeInfo& info = source.info();
  const Extent& extent = info.extent;
  volumes::SlabReader reader(source);
  Random random(seed ^ 0x6c61626cu);
  // Reservoir sampling (algorithm R) keeps an even choice of a label that fills the volume.
  std::vector<Coordinate> kept;
  std::uint64_t seen = 0;
  for (std::uint64_t z = 0; z < extent.z; ++z) {
    const std::byte* plane = reader.read(z, z + 1);
    for (std::uint64_t i = 0; i < extent.x * extent.y; ++i) {
      if (label_in(info, plane, i) != label) continue;
      const Coordinate here{i % extent.x, i / extent.x, z};
      ++seen;
      if (kept.size() < kLabelVoxels) {
        kept.push_back(here);
      } else if (const std::uint64_t slot = random.below(seen); slot < kLabelVoxels) {
        kept[slot] = here;
      }
    }
  }
  std::vector<Coordinate> points(count);
  for (Coordinate& p : points) p = kept[random.below(kept.size())];
  return points;
}

std::vector<std::uint64_t> labels_at(const VolumeSource& source,
                                     const std::vector<Coordinate>& points) {
  const volumes::VolumeInfo& info = source.info();
  std::vector<std::uint64_t> labels(points.size());
  if (source.data() != nullptr) {
    for (std::size_t i = 0; i < points.size(); ++i)
      labels[i] = label_in(info, source.data(), info.extent.index(points[i]));
    return labels;
  }
  std::vector<std::size_t> by_z(points.size());
  std::iota(by_z.begin(), by_z.end(), std::size_t{0});
  std::ranges::sort(by_z, {}, [&](std::size_t i) { return points[i].z; });
  volumes::SlabReader reader(source);
  const std::byte* plane = nullptr;
  std::uint64_t plane_z = 0;
  for (const std::size_t i : by_z) {
    if (plane == nullptr || plane_z != points[i].z) {
      plane_z = points[i].z;
      plane = reader.read(plane_z, plane_z + 1);
    }
    labels[i] = label_in(info, plane, points[i].x + info.extent.x * points[i].y);
  }
  return labels;
}

}  // namespace cvr::experiments
