#include "codecs/scalar_range.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "volumes/parallel.hpp"
#include "volumes/slabs.hpp"

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
  ScalarRange range;
  std::uint64_t finite = 0, others = 0;
  Coordinate first_other;
  const auto look = [&](std::uint64_t z0, std::span<const std::byte> voxels) {
    std::vector<PlaneFacts> planes(voxels.size() / volumes::plane_bytes(info));
    volumes::with_voxel_type(info.type, [&]<class T>() {
      volumes::parallel_for(threads, planes.size(), [&](unsigned, std::uint64_t z) {
        planes[z] = scan(volumes::values_of<T>(voxels).data() + z * plane, plane);
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
  };
  volumes::for_each_slab(source, volumes::planes_within(kSlabBytes, info), look);
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
