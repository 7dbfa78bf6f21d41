#include "volumes/generators/tiled_source.hpp"

#include <algorithm>
#include <vector>

#include "volumes/parallel.hpp"

namespace cvr::volumes {

namespace {

/// u64 voxels repeat the label in both halves, so that ids above 2^32 occur; narrower ones keep the lowest
/// bits.
template <class T>
T voxel_of(std::uint32_t label) {
  if constexpr (sizeof(T) == 8) {
    return std::uint64_t{label} << 32 | label;
  } else {
    return static_cast<T>(label);
  }
}

}  // namespace

TiledSource::TiledSource(const GeneratorRequest& request, VoxelType type, const Extent& tile)
    : info_{.extent = request.extent, .type = type, .kind = VolumeKind::kLabels},
      tile_(tile),
      threads_(request.threads < 1 ? 1 : request.threads) {}

void TiledSource::read(const Box& box, std::byte* out) const {
  if (box.size.voxels() == 0) return;
  const Coordinate& o = box.origin;
  const Extent first{o.x / tile_.x, o.y / tile_.y, o.z / tile_.z};
  const Extent tiles{(o.x + box.size.x - 1) / tile_.x - first.x + 1,
                     (o.y + box.size.y - 1) / tile_.y - first.y + 1,
                     (o.z + box.size.z - 1) / tile_.z - first.z + 1};
  std::vector<std::vector<std::uint32_t>> scratch(threads_);
  parallel_for(threads_, tiles.voxels(), [&](unsigned worker, std::uint64_t index) {
    const auto cut = [](std::uint64_t tile, std::uint64_t size, std::uint64_t origin, std::uint64_t length,
                        std::uint64_t& from, std::uint64_t& count) {
      from = std::max(tile * size, origin);
      count = std::min((tile + 1) * size, origin + length) - from;
    };
    Box part;
    cut(first.x + index % tiles.x, tile_.x, o.x, box.size.x, part.origin.x, part.size.x);
    cut(first.y + index / tiles.x % tiles.y, tile_.y, o.y, box.size.y, part.origin.y, part.size.y);
    cut(first.z + index / (tiles.x * tiles.y), tile_.z, o.z, box.size.z, part.origin.z, part.size.z);
    std::vector<std::uint32_t>& labels = scratch[worker];
    labels.resize(std::max(labels.size(), static_cast<std::size_t>(part.size.voxels())));
    fill(part, labels.data());
    with_label_type(info_.type, [&]<class T>() {
      const std::uint32_t* row = labels.data();
      for (std::uint64_t z = 0; z < part.size.z; ++z) {
        for (std::uint64_t y = 0; y < part.size.y; ++y, row += part.size.x) {
          const Coordinate local{part.origin.x - o.x, part.origin.y - o.y + y, part.origin.z - o.z + z};
          T* target = reinterpret_cast<T*>(out) + box.size.index(local);
          std::transform(row, row + part.size.x, target, voxel_of<T>);
        }
      }
    });
  });
}

}  // namespace cvr::volumes
