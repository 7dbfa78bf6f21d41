#include "volumes/metrics/gradients.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "volumes/metrics/magnitudes.hpp"
#include "volumes/parallel.hpp"

namespace cvr::volumes {

namespace {

constexpr std::uint64_t kSlabPlanes = 32;
constexpr double kEdgeShare = 0.05;

}  // namespace

template <class Take>
void EdgeVoxels::each_gradient(std::uint64_t z, Take&& take) const {
  const Extent& e = info_.extent;
  const std::uint64_t plane = e.x * e.y;
  with_voxel_type(info_.type, [&]<class T>() {
    const auto plane_at = [&](std::uint64_t at) {
      return reinterpret_cast<const T*>(planes_) + (at - first_plane_) * plane;
    };
    const std::uint64_t depth = info_.step_extent().z, below = z % depth == 0 ? z : z - 1,
                        above = (z + 1) % depth == 0 ? z : z + 1;
    const T *here = plane_at(z), *low = plane_at(below), *high = plane_at(above);
    const auto slope = [](T before, T after, std::uint64_t distance) {
      return distance == 0 ? 0.0
                           : (static_cast<double>(after) - static_cast<double>(before)) /
                                 static_cast<double>(distance);
    };
    for (std::uint64_t y = 0; y < e.y; ++y) {
      const std::uint64_t front = y == 0 ? y : y - 1, back = std::min(y + 1, e.y - 1);
      for (std::uint64_t x = 0; x < e.x; ++x) {
        const std::uint64_t left = x == 0 ? x : x - 1, right = std::min(x + 1, e.x - 1);
        const std::uint64_t i = x + e.x * y;
        const double dx = slope(here[left + e.x * y], here[right + e.x * y], right - left);
        const double dy = slope(here[x + e.x * front], here[x + e.x * back], back - front);
        const double dz = slope(low[i], high[i], above - below);
        const double squared = dx * dx + dy * dy + dz * dz;
        if (std::isfinite(squared)) take(i, squared);
      }
    }
  });
}

EdgeVoxels::EdgeVoxels(const VolumeSource& source, unsigned threads)
    : info_(source.info()), reader_(source) {
  std::vector<Magnitudes> found(std::max(threads, 1u));
  for (std::uint64_t z0 = 0; z0 < info_.extent.z; z0 += kSlabPlanes) {
    const std::uint64_t z1 = std::min(z0 + kSlabPlanes, info_.extent.z);
    load(z0, z1);
    parallel_for(threads, z1 - z0, [&](unsigned worker, std::uint64_t i) {
      each_gradient(z0 + i, [&](std::uint64_t, double squared) { found[worker].add(squared); });
    });
  }
  for (std::size_t worker = 1; worker < found.size(); ++worker) found[0].add(found[worker]);
  const Magnitudes& all = found[0];
  threshold_ = std::numeric_limits<double>::infinity();
  if (all.total() == 0) return;
  const auto edges =
      static_cast<std::uint64_t>(std::ceil(kEdgeShare * static_cast<double>(all.total())));
  // The bin of 0 also holds the denormal squares: too small to be told from no gradient.
  threshold_ = std::max(all.at_rank(all.total() - edges), std::numeric_limits<double>::min());
}

void EdgeVoxels::load(std::uint64_t z0, std::uint64_t z1) {
  first_plane_ = z0 == 0 ? 0 : z0 - 1;
  planes_ = reader_.read(first_plane_, std::min(z1 + 1, info_.extent.z));
}

void EdgeVoxels::mark(std::uint64_t z, std::uint8_t* edges) const {
  std::memset(edges, 0, info_.extent.x * info_.extent.y);
  each_gradient(z,
                [&](std::uint64_t i, double squared) { edges[i] = squared >= threshold_ ? 1 : 0; });
}

}  // namespace cvr::volumes
