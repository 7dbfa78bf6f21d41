// Label volumes that every peer codec must survive, and the extents at which they are tried.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "volumes/volume.hpp"

namespace cvr::test {

enum class Content {
  kZero,          ///< one label: 0
  kLargest,       ///< one label: the largest of the type
  kCheckerboard,  ///< 0 and the largest of the type, alternating
  kDistinct,      ///< every voxel its own label, as far as the type has labels
  kCells,         ///< boxes of irregular size with labels far apart
  kNoise,         ///< random labels out of few, single voxels
  kExtremes,  ///< 0, 1, 2^31, 2^32-1, 2^32, 2^63, 2^64-1 (cut to the type) in runs of changing length
};
inline constexpr Content kContents[] = {
    Content::kZero,  Content::kLargest, Content::kCheckerboard, Content::kDistinct,
    Content::kCells, Content::kNoise,   Content::kExtremes};
inline constexpr volumes::Extent kExtents[] = {{1, 1, 1}, {1, 9, 1},    {11, 1, 1},   {1, 1, 13},
                                               {5, 7, 9}, {65, 33, 17}, {16, 16, 16}, {3, 130, 2}};
inline constexpr volumes::VoxelType kLabelTypes[] = {
    volumes::VoxelType::kU8, volumes::VoxelType::kU16, volumes::VoxelType::kU32,
    volumes::VoxelType::kU64};

/// A well mixed 64-bit value for each input (splitmix64).
inline std::uint64_t mix(std::uint64_t n) {
  n += 0x9e3779b97f4a7c15u;
  n = (n ^ (n >> 30)) * 0xbf58476d1ce4e5b9u;
  n = (n ^ (n >> 27)) * 0x94d049bb133111ebu;
  return n ^ (n >> 31);
}

inline std::uint64_t sample_label(Content content, std::uint64_t x, std::uint64_t y,
                                  std::uint64_t z, std::uint64_t index) {
  static constexpr std::uint64_t kExtreme[] = {0,
                                               1,
                                               std::uint64_t{1} << 31,
                                               0xffffffffu,
                                               std::uint64_t{1} << 32,
                                               std::uint64_t{1} << 63,
                                               ~std::uint64_t{0}};
  switch (content) {
    case Content::kZero:
      return 0;
    case Content::kLargest:
      return ~std::uint64_t{0};
    case Content::kCheckerboard:
      return ((x + y + z) & 1) != 0 ? ~std::uint64_t{0} : 0;
    case Content::kDistinct:
      return index;
    case Content::kCells:
      return mix(((x + y / 3) / 6) * 1000003 + ((y + z / 2) / 5) * 1009 + z / 4);
    case Content::kNoise:
      return mix(index) % 5 * 50;
    case Content::kExtremes:
      return kExtreme[(x / (1 + z % 3) + y * 3 + z) % 7];
  }
  return 0;
}

/// Labels are cut to the type.
inline volumes::Volume sample_volume(Content content, const volumes::Extent& extent,
                                     volumes::VoxelType type) {
  volumes::Volume volume(
      {.extent = extent, .type = type, .kind = volumes::VolumeKind::kLabels, .voxel_unit = {}});
  volumes::with_label_type(type, [&]<class T>() {
    std::uint64_t i = 0;
    const auto voxels = volume.voxels<T>();
    for (std::uint64_t z = 0; z < extent.z; ++z) {
      for (std::uint64_t y = 0; y < extent.y; ++y) {
        for (std::uint64_t x = 0; x < extent.x; ++x, ++i) {
          voxels[i] = static_cast<T>(sample_label(content, x, y, z, i));
        }
      }
    }
  });
  return volume;
}

inline std::string describe(Content content, const volumes::VolumeInfo& info) {
  return "content " + std::to_string(static_cast<int>(content)) + ", " +
         volumes::to_string(info.extent) + " " + std::string(volumes::name_of(info.type));
}

}  // namespace cvr::test
