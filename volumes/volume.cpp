#include "volumes/volume.hpp"

#include <fmt/format.h>

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

std::string_view name_of(VoxelType type) {
  switch (type) {
    case VoxelType::kU8:
      return "u8";
    case VoxelType::kU16:
      return "u16";
    case VoxelType::kU32:
      return "u32";
    case VoxelType::kU64:
      return "u64";
    case VoxelType::kI16:
      return "i16";
    case VoxelType::kF32:
      return "f32";
  }
  return "?";
}

std::optional<VoxelType> voxel_type_from_name(std::string_view name) {
  for (const VoxelType type : kVoxelTypes) {
    if (name_of(type) == name) return type;
  }
  return std::nullopt;
}

std::string_view name_of(VolumeKind kind) {
  return kind == VolumeKind::kLabels ? "labels" : "scalars";
}

std::optional<VolumeKind> volume_kind_from_name(std::string_view name) {
  if (name == "labels") return VolumeKind::kLabels;
  if (name == "scalars") return VolumeKind::kScalars;
  return std::nullopt;
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
