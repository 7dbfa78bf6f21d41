// What a volume is: extent, voxel type, kind, voxel size, and voxels in memory with x fastest.
//
// The voxel (x, y, z) lies at index x + X * (y + Y * z). Extents are written (X, Y, Z) everywhere;
// readers of formats with another order (HDF5: z y x) exchange the axes at their own door. A series
// is one volume whose time steps are stacked along z.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "volumes/buffer.hpp"

namespace cvr::volumes {

static_assert(std::endian::native == std::endian::little,
              "streams and files are written as they lie in memory");

enum class VoxelType : std::uint8_t { kU8, kU16, kU32, kU64, kI16, kF32 };
enum class VolumeKind : std::uint8_t {
  kLabels,   ///< one integer label a voxel; types u8, u16, u32, u64
  kScalars,  ///< one measured value per voxel; types u8, u16, i16, f32
};

inline constexpr std::array kVoxelTypes{VoxelType::kU8,  VoxelType::kU16, VoxelType::kU32,
                                        VoxelType::kU64, VoxelType::kI16, VoxelType::kF32};

/// Those that labels may have, and those of scalars.
inline constexpr std::array kLabelTypes{VoxelType::kU8, VoxelType::kU16, VoxelType::kU32,
                                        VoxelType::kU64};
inline constexpr std::array kScalarTypes{VoxelType::kU8, VoxelType::kU16, VoxelType::kI16,
                                         VoxelType::kF32};

/// Bytes a voxel.
std::size_t size_of(VoxelType type);
/// "u8", "u16", "u32", "u64", "i16", "f32".
std::string_view name_of(VoxelType type);
std::optional<VoxelType> voxel_type_from_name(std::string_view name);
/// "labels" or "scalars".
std::string_view name_of(VolumeKind kind);
std::optional<VolumeKind> volume_kind_from_name(std::string_view name);

/// Whether labels may have this type: unsigned integers.
constexpr bool is_label_type(VoxelType type) {
  return type != VoxelType::kI16 && type != VoxelType::kF32;
}

struct Coordinate {
  std::uint64_t x = 0, y = 0, z = 0;
  bool operator==(const Coordinate&) const = default;
};

struct Extent {
  std::uint64_t x = 0, y = 0, z = 0;
  bool operator==(const Extent&) const = default;
  std::uint64_t voxels() const { return x * y * z; }
  bool contains(const Coordinate& c) const { return c.x < x && c.y < y && c.z < z; }
  std::uint64_t index(const Coordinate& c) const { return c.x + x * (c.y + y * c.z); }
  /// The coordinate of an index < voxels().
  Coordinate coordinate(std::uint64_t i) const { return {i % x, i / x % y, i / x / y}; }
};

/// ceil(a / b) on every axis.
Extent ceil_div(const Extent& extent, std::uint64_t divisor);
/// "512x512x256".
std::string to_string(const Extent& extent);

/// The voxels origin <= c < origin + size.
struct Box {
  Coordinate origin;
  Extent size;
};

struct VolumeInfo {
  Extent extent;
  VoxelType type = VoxelType::kU8;
  VolumeKind kind = VolumeKind::kLabels;
  std::array<double, 3> voxel_size{1, 1, 1};  ///< along x, y, z, in voxel_unit
  std::string voxel_unit;                     ///< "nm", "um", "mm", ...; empty when unknown
  std::array<double, 3> offset{
      0, 0,
      0};  ///< where voxel (0, 0, 0) lies, in voxel_unit: voxel i of an axis at offset + i * voxel_size
  std::uint64_t time_steps = 1;  ///< of a series, stacked along z; divides extent.z

  /// Of one time step.
  Extent step_extent() const { return {extent.x, extent.y, extent.z / time_steps}; }
  std::uint64_t bytes() const { return extent.voxels() * size_of(type); }
};

/// A whole volume in memory.
class Volume {
 public:
  Volume() = default;
  /// Voxels of undefined value. Throws std::bad_alloc.
  explicit Volume(const VolumeInfo& info) : info_(info), data_(info.bytes()) {}

  const VolumeInfo& info() const { return info_; }
  VolumeInfo& info() { return info_; }
  const Extent& extent() const { return info_.extent; }
  std::byte* data() { return data_.data(); }
  const std::byte* data() const { return data_.data(); }
  std::span<const std::byte> bytes() const { return data_.bytes(); }

  /// All voxels, x fastest. T must have the size of the voxel type.
  template <class T>
  std::span<T> voxels() {
    return {reinterpret_cast<T*>(data_.data()), info_.extent.voxels()};
  }
  template <class T>
  std::span<const T> voxels() const {
    return {reinterpret_cast<const T*>(data_.data()), info_.extent.voxels()};
  }
  /// The label at a coordinate, widened. For label volumes.
  std::uint64_t label(const Coordinate& c) const;

 private:
  VolumeInfo info_;
  Buffer data_;
};

/// Calls f.template operator()<T>() with the C++ type of a label voxel type (u8, u16, u32, u64).
template <class F>
decltype(auto) with_label_type(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::kU8:
      return f.template operator()<std::uint8_t>();
    case VoxelType::kU16:
      return f.template operator()<std::uint16_t>();
    case VoxelType::kU64:
      return f.template operator()<std::uint64_t>();
    default:
      return f.template operator()<std::uint32_t>();
  }
}

/// Calls f.template operator()<T>() with the C++ type of any voxel type.
template <class F>
decltype(auto) with_voxel_type(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::kI16:
      return f.template operator()<std::int16_t>();
    case VoxelType::kF32:
      return f.template operator()<float>();
    default:
      return with_label_type(type, std::forward<F>(f));
  }
}

}  // namespace cvr::volumes
