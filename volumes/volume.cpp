#include "volumes/volume.hpp"

#include <fmt/format.h>

#include "volumes/enum_names.hpp"

namespace cvr::volumes {

std::size_t size_of(VoxelType type) {
  switch (type) {
    case VoxelType::kU8:
      return 1;
    case VoxelType::kU16:
    case VoxelType::kI16:
      return 2;
    case VoxelType::kU32:
    case VoxelType::kF32:
      return 4;
    case VoxelType::kU64:
      return 8;
  }
  return 0;
}

namespace {

constexpr auto kTypeNames = enum_names<VoxelType>({{VoxelType::kU8, "u8"},
                                                   {VoxelType::kU16, "u16"},
                                                   {VoxelType::kU32, "u32"},
                                                   {VoxelType::kU64, "u64"},
                                                   {VoxelType::kI16, "i16"},
                                                   {VoxelType::kF32, "f32"}});
constexpr auto kKindNames =
    enum_names<VolumeKind>({{VolumeKind::kLabels, "labels"}, {VolumeKind::kScalars, "scalars"}});

}  // namespace

std::string_view name_of(VoxelType type) { return kTypeNames.of(type); }

std::optional<VoxelType> voxel_type_from_name(std::string_view name) {
  return kTypeNames.find(name);
}

std::string_view name_of(VolumeKind kind) { return kKindNames.of(kind); }

std::optional<VolumeKind> volume_kind_from_name(std::string_view name) {
  return kKindNames.find(name);
}

Extent ceil_div(const Extent& extent, std::uint64_t divisor) {
  const auto up = [divisor](std::uint64_t n) { return n / divisor + (n % divisor != 0 ? 1 : 0); };
  return {up(extent.x), up(extent.y), up(extent.z)};
}

std::string to_string(const Extent& extent) {
  return fmt::format("{}x{}x{}", extent.x, extent.y, extent.z);
}

std::uint64_t Volume::label(const Coordinate& c) const {
  const std::uint64_t index = info_.extent.index(c);
  return with_label_type(info_.type,
                         [&]<class T>() -> std::uint64_t { return voxels<T>()[index]; });
}

}  // namespace cvr::volumes
