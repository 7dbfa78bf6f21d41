#include "volumes/generators/tiled_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "volumes/error.hpp"
#include "volumes/parallel.hpp"

namespace cvr::volumes {

namespace {

/// u64 voxels repeat the label in both halves, so that ids above 2^32 occur; narrower ones keep the
/// lowest bits.
template <class T>
T voxel_of(std::uint32_t label) {
  if constexpr (sizeof(T) == 8) {
    return std::uint64_t{label} << 32 | label;
  } else {
    return static_cast<T>(label);
  }
}

/// Where row (y, z) of a part begins among the voxels of the box.
std::uint64_t row_index(const Box& part, const Box& box, std::uint64_t y, std::uint64_t z) {
  const Coordinate &p = part.origin, &o = box.origin;
  return box.size.index({p.x - o.x, p.y - o.y + y, p.z - o.z + z});
}

constexpr Extent kScalarTile{256, 16, 8};

VoxelType scalar_type(std::string_view kind, double bits) {
  if (bits == 8) return VoxelType::kU8;
  if (bits == 16) return VoxelType::kU16;
  if (bits == 32) return VoxelType::kF32;
  throw InputError(fmt::format("generator {}: bits: expected 8, 16 or 32, found {}", kind, bits));
}

template <class T>
T scalar_of(float value) {
  if constexpr (std::is_floating_point_v<T>) {
    return value;
  } else {
    const float cut = std::clamp(value, 0.0F, 1.0F);
    return static_cast<T>(cut * static_cast<float>(std::numeric_limits<T>::max()) + 0.5F);
  }
}

}  // namespace

TiledVolume::TiledVolume(const GeneratorRequest& request, VoxelType type, VolumeKind kind,
                         const Extent& tile, std::uint64_t time_steps)
    : info_{.extent = request.extent,
            .type = type,
            .kind = kind,
            .voxel_unit = {},
            .time_steps = time_steps},
      tile_(tile),
      threads_(request.threads < 1 ? 1 : request.threads) {}

void TiledVolume::read(const Box& box, std::byte* out) const {
  if (box.size.voxels() == 0) return;
  const Coordinate& o = box.origin;
  const Extent first{o.x / tile_.x, o.y / tile_.y, o.z / tile_.z};
  const Extent tiles{(o.x + box.size.x - 1) / tile_.x - first.x + 1,
                     (o.y + box.size.y - 1) / tile_.y - first.y + 1,
                     (o.z + box.size.z - 1) / tile_.z - first.z + 1};
  std::vector<std::vector<std::uint32_t>> scratch(threads_);
  parallel_for(threads_, tiles.voxels(), [&](unsigned worker, std::uint64_t index) {
    const auto cut = [](std::uint64_t tile, std::uint64_t size, std::uint64_t origin,
                        std::uint64_t length, std::uint64_t& from, std::uint64_t& count) {
      from = std::max(tile * size, origin);
      count = std::min((tile + 1) * size, origin + length) - from;
    };
    Box part;
    cut(first.x + index % tiles.x, tile_.x, o.x, box.size.x, part.origin.x, part.size.x);
    cut(first.y + index / tiles.x % tiles.y, tile_.y, o.y, box.size.y, part.origin.y, part.size.y);
    cut(first.z + index / (tiles.x * tiles.y), tile_.z, o.z, box.size.z, part.origin.z,
        part.size.z);
    fill_part(part, box, out, scratch[worker]);
  });
}

void TiledSource::fill_part(const Box& part, const Box& box, std::byte* out,
                            std::vector<std::uint32_t>& labels) const {
  labels.resize(std::max(labels.size(), static_cast<std::size_t>(part.size.voxels())));
  fill(part, labels.data());
  with_label_type(info().type, [&]<class T>() {
    const std::uint32_t* row = labels.data();
    for (std::uint64_t z = 0; z < part.size.z; ++z) {
      for (std::uint64_t y = 0; y < part.size.y; ++y, row += part.size.x)
        std::transform(row, row + part.size.x,
                       reinterpret_cast<T*>(out) + row_index(part, box, y, z), voxel_of<T>);
    }
  });
}

TiledScalars::TiledScalars(std::string_view kind, const GeneratorRequest& request,
                           std::uint64_t time_steps)
    : TiledVolume(request, scalar_type(kind, request["bits"]), VolumeKind::kScalars, kScalarTile,
                  time_steps) {}

void TiledScalars::fill_part(const Box& part, const Box& box, std::byte* out,
                             std::vector<std::uint32_t>&) const {
  std::array<float, kScalarTile.x> row;
  with_voxel_type(info().type, [&]<class T>() {
    for (std::uint64_t z = 0; z < part.size.z; ++z) {
      for (std::uint64_t y = 0; y < part.size.y; ++y) {
        fill_row({part.origin.x, part.origin.y + y, part.origin.z + z}, part.size.x, row.data());
        std::transform(row.data(), row.data() + part.size.x,
                       reinterpret_cast<T*>(out) + row_index(part, box, y, z), scalar_of<T>);
      }
    }
  });
}

}  // namespace cvr::volumes
