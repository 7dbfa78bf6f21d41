#include "gpu/scalars/reference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "gpu/reference/vector.hpp"
#include "volumes/parallel.hpp"

namespace cvr::gpu {

namespace {

constexpr double kLeastTransmittance = 1.0 / 256;
constexpr double kLeastAlong = 1.0 / 1024;

template <class F>
decltype(auto) with_scalars(const volumes::Volume& volume, F&& f) {
  switch (volume.info().type) {
    case volumes::VoxelType::kU8:
      return f(volume.voxels<std::uint8_t>());
    case volumes::VoxelType::kU16:
      return f(volume.voxels<std::uint16_t>());
    case volumes::VoxelType::kI16:
      return f(volume.voxels<std::int16_t>());
    default:
      return f(volume.voxels<float>());
  }
}

/// The values of a volume at any place: trilinear between voxel centres, constant beyond the outer
/// ones.
template <class T>
class Field {
 public:
  Field(const volumes::Extent& extent, std::span<const T> voxels)
      : extent_(extent), voxels_(voxels) {}

  double voxel(const std::array<std::int64_t, 3>& at) const {
    return static_cast<double>(voxels_[extent_.index(
        {clamped(at[0], extent_.x), clamped(at[1], extent_.y), clamped(at[2], extent_.z)})]);
  }
  /// Calls take(voxel, weight) for the eight voxels around a place.
  template <class Take>
  static void corners(const Vector3& place, Take&& take) {
    std::array<std::int64_t, 3> base;
    Vector3 part;
    for (std::size_t a = 0; a < 3; ++a) {
      base[a] = static_cast<std::int64_t>(std::floor(place[a]));
      part[a] = place[a] - static_cast<double>(base[a]);
    }
    for (unsigned corner = 0; corner < 8; ++corner) {
      std::array<std::int64_t, 3> at = base;
      double weight = 1;
      for (std::size_t a = 0; a < 3; ++a) {
        const bool far = (corner >> a & 1) != 0;
        at[a] += far ? 1 : 0;
        weight *= far ? part[a] : 1 - part[a];
      }
      take(at, weight);
    }
  }
  double value(const Vector3& place) const {
    double sum = 0;
    corners(place, [&](const auto& at, double weight) { sum += weight * voxel(at); });
    return sum;
  }
  /// Central differences of the voxels, interpolated.
  Vector3 slope(const Vector3& place) const {
    Vector3 sum{0, 0, 0};
    corners(place, [&](const auto& at, double weight) {
      for (std::size_t a = 0; a < 3; ++a) {
        auto before = at, after = at;
        --before[a];
        ++after[a];
        sum[a] += weight * 0.5 * (voxel(after) - voxel(before));
      }
    });
    return sum;
  }

 private:
  static std::uint64_t clamped(std::int64_t at, std::uint64_t size) {
    return static_cast<std::uint64_t>(
        std::clamp<std::int64_t>(at, 0, static_cast<std::int64_t>(size) - 1));
  }
  volumes::Extent extent_;
  std::span<const T> voxels_;
};

TransferEntry entry_at(const std::vector<TransferEntry>& table, const ValueRange& range,
                       double value) {
  const double width = range.largest - range.least;
  const double last = static_cast<double>(table.size() - 1);
  const double at = width > 0 ? std::clamp((value - range.least) / width * last, 0.0, last) : 0;
  const auto below = std::min(static_cast<std::size_t>(at), table.size() - 2);
  const double part = at - static_cast<double>(below);
  TransferEntry entry;
  for (std::size_t c = 0; c < entry.size(); ++c)
    entry[c] = table[below][c] + part * (table[below + 1][c] - table[below][c]);
  return entry;
}

}  // namespace

ValueRange value_range(const volumes::Volume& volume) {
  if (volume.info().type == volumes::VoxelType::kU8) return {0, 255};
  return with_scalars(volume, [](auto voxels) {
    double least = std::numeric_limits<double>::infinity(), largest = -least;
    for (const auto voxel : voxels) {
      const auto value = static_cast<double>(voxel);
      if (!std::isfinite(value)) continue;
      least = std::min(least, value);
      largest = std::max(largest, value);
    }
    return least <= largest ? ValueRange{least, largest} : ValueRange{0, 0};
  });
}

Image render_scalars(const volumes::Volume& volume, const Scene& scene, const ValueRange& range,
                     const Camera& camera, unsigned threads) {
  const volumes::VolumeInfo& info = volume.info();
  const SliceOrder order = slice_order(info, camera);
  const std::vector<TransferEntry> table = transfer_table(scene.transfer);
  const Vector3 scale = world_scale(info), eye = world_from_scene(info, camera.eye);
  const Vector3 forward = normalize(camera.target - camera.eye),
                right = normalize(cross(forward, camera.up)), up = cross(right, forward);
  const double half = std::tan(camera.vertical_fov_degrees * std::numbers::pi / 360);
  const Vector3 light = normalize(scene.light);
  const std::array<std::uint64_t, 3> extent{info.extent.x, info.extent.y, info.extent.z};
  const std::uint64_t planes = (extent[order.axis] - 1) * scene.slice_samples;

  Image image{
      .width = scene.width, .height = scene.height, .colour = {}, .labels = {}, .complete = {}};
  image.colour.resize(3 * image.pixels());
  image.labels.assign(image.pixels(), kNoLabel);
  image.complete.assign(image.pixels(), 1);

  with_scalars(volume, [&](auto voxels) {
    const Field field(info.extent, voxels);
    volumes::parallel_for(threads, scene.height, [&](unsigned, std::uint64_t py) {
      for (std::uint32_t px = 0; px < scene.width; ++px) {
        const double a = (2.0 * px + 1) / scene.width - 1,
                     b = 1 - (2.0 * static_cast<double>(py) + 1) / scene.height;
        const Vector3 world =
            forward + (a * half * scene.width / scene.height) * right + (b * half) * up;
        const Vector3 ray = world / scale;
        const double along = order.backwards ? -ray[order.axis] : ray[order.axis];
        double across = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
          if (axis != order.axis) across = std::max(across, std::abs(ray[axis]));
        Vector3 colour{0, 0, 0};
        double transmittance = 1;
        const double step = length(world) / along / scene.slice_samples;
        for (std::uint64_t plane = 0; along > kLeastAlong * across && plane < planes; ++plane) {
          if (transmittance < kLeastTransmittance) break;
          const double depth = (static_cast<double>(plane) + 0.5) / scene.slice_samples;
          const double s =
              order.backwards ? static_cast<double>(extent[order.axis] - 1) - depth : depth;
          const Vector3 start = eye / scale - Vector3{0.5, 0.5, 0.5};
          const double t = (s - start[order.axis]) / ray[order.axis];
          Vector3 place = start + t * ray;
          place[order.axis] = s;
          bool inside = t >= 0;
          for (std::size_t axis = 0; axis < 3; ++axis)
            inside = inside && place[axis] >= -0.5 &&
                     place[axis] < static_cast<double>(extent[axis]) - 0.5;
          if (!inside) continue;
          const TransferEntry entry = entry_at(table, range, field.value(place));
          if (entry[3] <= 0) continue;
          const Vector3 slope = field.slope(place) / scale;
          const double steepness = length(slope);
          double lambert = 1;
          if (steepness > 0) {
            const double knee = kShadingKnee * (range.largest - range.least);
            const double shaded = knee > 0 ? std::min(1.0, steepness / knee) : 1;
            lambert -= shaded * (1 - scene.ambient) * (1 - std::abs(dot(slope, light)) / steepness);
          }
          const double alpha = 1 - std::exp(-entry[3] * step);
          for (std::size_t c = 0; c < 3; ++c)
            colour[c] += transmittance * alpha * lambert * entry[c];
          transmittance *= 1 - alpha;
        }
        float* out = image.colour.data() + 3 * (px + std::size_t{scene.width} * py);
        for (std::size_t c = 0; c < 3; ++c)
          out[c] = static_cast<float>(colour[c] + transmittance * scene.background[c] / 255);
      }
    });
  });
  return image;
}

}  // namespace cvr::gpu
