#include "codecs/tvq/samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "volumes/slabs.hpp"

namespace cvr::codecs::tvq {

namespace {

constexpr std::uint64_t kSlab = 16;  // planes read at a time

/// Calls f.template operator()<T>() with the C++ type of a scalar.
template <class F>
decltype(auto) with_scalar_type(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::kU16:
      return f.template operator()<std::uint16_t>();
    case VoxelType::kI16:
      return f.template operator()<std::int16_t>();
    case VoxelType::kF32:
      return f.template operator()<float>();
    default:
      return f.template operator()<std::uint8_t>();
  }
}

template <class T>
Expected<Survey> survey_integers(const VolumeSource& source, ZeroValue zero) {
  std::vector<std::uint64_t> histogram(std::size_t{1} << (8 * sizeof(T)), 0);
  constexpr int kFirst = std::numeric_limits<T>::min();
  volumes::for_each_slab(source, kSlab, [&](std::uint64_t, std::span<const std::byte> voxels) {
    for (const T v : volumes::values_of<T>(voxels))
      ++histogram[static_cast<std::size_t>(v - kFirst)];
  });
  Survey result;
  Domain& domain = result.domain;
  const auto present = [](std::uint64_t n) { return n > 0; };
  domain.low =
      kFirst + static_cast<int>(std::ranges::find_if(histogram, present) - histogram.begin());
  domain.high =
      kFirst + static_cast<int>(histogram.size() - 1 -
                                static_cast<std::size_t>(
                                    std::find_if(histogram.rbegin(), histogram.rend(), present) -
                                    histogram.rbegin()));
  domain.zero = domain.low <= 0 && domain.high >= 0 ? 0 : domain.low;
  if (zero == ZeroValue::kLeast) domain.zero = domain.low;
  if (zero == ZeroValue::kMode)
    domain.zero =
        kFirst + static_cast<int>(std::ranges::max_element(histogram) - histogram.begin());
  return result;
}

Expected<Survey> survey_floats(const VolumeSource& source, ZeroValue zero, bool mask) {
  if (zero == ZeroValue::kMode)
    return fail(
        ErrorCode::kUnsupported,
        "parameter 'zero': f32 volumes have no most frequent value; expected zero or least");
  Survey result;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  std::uint64_t strange = 0, first = 0;
  const std::uint64_t plane = source.info().extent.x * source.info().extent.y;
  volumes::for_each_slab(source, kSlab, [&](std::uint64_t z0, std::span<const std::byte> slab) {
    const auto voxels = volumes::values_of<float>(slab);
    const std::uint64_t begin = z0 * plane;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const float v = voxels[i];
      if (std::isfinite(v)) {
        low = std::min(low, v);
        high = std::max(high, v);
        continue;
      }
      if (strange++ == 0) first = begin + i;
      if (!mask) continue;
      auto& runs = result.exceptions;
      if (runs.empty() || runs.back().first + runs.back().count != begin + i ||
          runs.back().count == std::numeric_limits<std::uint32_t>::max()) {
        runs.push_back({begin + i, 0});
      }
      ++runs.back().count;
      result.exception_bits.push_back(std::bit_cast<std::uint32_t>(v));
    }
  });
  if (strange > 0 && !mask) {
    const Extent& e = source.info().extent;
    return fail(
        ErrorCode::kUnsupported,
        fmt::format("expected finite voxels, found {} of {} that are NaN or infinite, the first at "
                    "({}, {}, {}); nonfinite=mask keeps them aside",
                    strange, e.voxels(), first % e.x, first / e.x % e.y, first / (e.x * e.y)));
  }
  if (!(low <= high)) low = high = 0;  // nothing is finite
  Domain& domain = result.domain;
  domain.offset = (low <= 0 && high >= 0 && zero == ZeroValue::kZero) ? 0.0f : low;
  // The offset lies in the range, and is 0 wherever the range could exceed what a float holds.
  if (!std::isfinite(high - low)) domain.offset = 0;
  const double range = static_cast<double>(high) - static_cast<double>(low);
  domain.exponent = range > 0 ? std::min(std::ilogb(range), 127) : 0;
  const double unit =
      std::ldexp(1.0, domain.exponent - static_cast<int>(Domain::fraction_of(VoxelType::kF32)));
  domain.low = static_cast<std::int32_t>(
      std::ceil((static_cast<double>(low) - static_cast<double>(domain.offset)) / unit));
  domain.high = static_cast<std::int32_t>(
      std::floor((static_cast<double>(high) - static_cast<double>(domain.offset)) / unit));
  return result;
}

template <class T>
std::vector<float> read_typed(const VolumeSource& source, const Domain& domain,
                              const volumes::Box& box) {
  const Extent blocks = ceil_div(box.size, kBlockEdge);
  std::vector<float> samples(blocks.voxels() * kBlockVoxels);
  std::vector<T> layer;
  for (std::uint64_t bz = 0; bz < blocks.z; ++bz) {
    const std::uint64_t depth = std::min<std::uint64_t>(kBlockEdge, box.size.z - bz * kBlockEdge);
    const Extent size{box.size.x, box.size.y, depth};
    layer.resize(size.voxels());
    source.read({{box.origin.x, box.origin.y, box.origin.z + bz * kBlockEdge}, size},
                reinterpret_cast<std::byte*>(layer.data()));
    float* block = samples.data() + bz * blocks.x * blocks.y * kBlockVoxels;
    for (std::uint64_t by = 0; by < blocks.y; ++by) {
      for (std::uint64_t bx = 0; bx < blocks.x; ++bx, block += kBlockVoxels) {
        double sum = 0;
        unsigned finite = 0;
        for (unsigned i = 0; i < kBlockVoxels; ++i) {
          const T v = layer[size.index({std::min<std::uint64_t>(bx * 4 + (i & 3), size.x - 1),
                                        std::min<std::uint64_t>(by * 4 + (i >> 2 & 3), size.y - 1),
                                        std::min<std::uint64_t>(i >> 4, depth - 1)})];
          if constexpr (std::is_same_v<T, float>) {
            block[i] = static_cast<float>(std::ldexp(
                static_cast<double>(v) - static_cast<double>(domain.offset), -domain.exponent));
            if (std::isfinite(v)) sum += static_cast<double>(block[i]), ++finite;
          } else {
            block[i] = static_cast<float>(static_cast<int>(v) - domain.zero);
            ++finite;
          }
        }
        if (finite == kBlockVoxels) continue;
        const float mean = finite == 0 ? 0.0f : static_cast<float>(sum / finite);
        for (unsigned i = 0; i < kBlockVoxels; ++i) {
          if (!std::isfinite(block[i])) block[i] = mean;
        }
      }
    }
  }
  return samples;
}

}  // namespace

Expected<Survey> survey(const VolumeSource& source, ZeroValue zero, bool mask) {
  auto result = with_scalar_type(source.info().type, [&]<class T>() -> Expected<Survey> {
    if constexpr (std::is_same_v<T, float>) {
      return survey_floats(source, zero, mask);
    } else {
      return survey_integers<T>(source, zero);
    }
  });
  if (!result) return result;
  result->domain.type = source.info().type;
  result->domain.fraction = Domain::fraction_of(source.info().type);
  return result;
}

std::vector<float> read_blocks(const VolumeSource& source, const Domain& domain,
                               const volumes::Box& box) {
  return with_scalar_type(source.info().type,
                          [&]<class T>() { return read_typed<T>(source, domain, box); });
}

}  // namespace cvr::codecs::tvq
