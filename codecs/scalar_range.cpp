#include "codecs/scalar_range.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "volumes/parallel.hpp"

namespace cvr::codecs {

namespace {

constexpr std::uint64_t kSlabBytes = std::uint64_t{16} << 20;

struct PlaneFacts {
  double minimum = 0, maximum = 0;  ///< of the finite voxels
  std::uint64_t finite = 0, others = 0;
  std::uint64_t first_other = 0;  ///< index in the plane
};

template <class T>
PlaneFacts scan(const T* voxels, std::uint64_t count) {
  PlaneFacts facts;
  if constexpr (std::is_floating_point_v<T>) {
    for (std::uint64_t i = 0; i < count; ++i) {
      if (!std::isfinite(voxels[i])) {
        if (facts.others++ == 0) facts.first_other = i;
        continue;
      }
      const double value = voxels[i];
      facts.minimum = facts.finite == 0 ? value : std::min(facts.minimum, value);
      facts.maximum = facts.finite == 0 ? value : std::max(facts.maximum, value);
      ++facts.finite;
    }
  } else {
    const auto [least, largest] = std::minmax_element(voxels, voxels + count);
    facts = {static_cast<double>(*least), static_cast<double>(*largest), count, 0, 0};
  }
  return facts;
}

}  // namespace

Expected<ScalarRange> finite_range(const VolumeSource& source, unsigned threads) {
  const VolumeInfo& info = source.info();
  const std::uint64_t plane = info.extent.x * info.extent.y;
  const std::uint64_t depth = std::max<std::uint64_t>(1, kSlabBytes / (plane * size_of(info.type)));
  volumes::SlabReader reader(source);
  ScalarRange range;
  std::uint64_t finite = 0, others = 0;
  Coordinate first_other;
  for (std::uint64_t z0 = 0; z0 < info.extent.z; z0 += depth) {
    const std::uint64_t z1 = std::min(z0 + depth, info.extent.z);
    const std::byte* voxels = reader.read(z0, z1);
    std::vector<PlaneFacts> planes(z1 - z0);
    volumes::with_voxel_type(info.type, [&]<class T>() {
      volumes::parallel_for(threads, z1 - z0, [&](unsigned, std::uint64_t z) {
        planes[z] = scan(reinterpret_cast<const T*>(voxels) + z * plane, plane);
      });
    });
    for (std::uint64_t z = 0; z < planes.size(); ++z) {
      const PlaneFacts& facts = planes[z];
      if (facts.others > 0 && others == 0)
        first_other = {facts.first_other % info.extent.x, facts.first_other / info.extent.x,
                       z0 + z};
      others += facts.others;
      if (facts.finite == 0) continue;
      range.minimum = finite == 0 ? facts.minimum : std::min(range.minimum, facts.minimum);
      range.maximum = finite == 0 ? facts.maximum : std::max(range.maximum, facts.maximum);
      finite += facts.finite;
    }
  }
  if (others > 0) {
    return fail(
        ErrorCode::kUnsupported,
        fmt::format(
            "expected finite voxels, found {} that are NaN or infinite, the first at ({}, {}, {})",
            others, first_other.x, first_other.y, first_other.z));
  }
  return range;
}

}  // namespace cvr::codecs
