#include "volumes/io/format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <limits>

#include "volumes/slabs.hpp"

namespace cvr::volumes {

namespace {

constexpr std::uint64_t kMaximumBytes = std::uint64_t{1} << 48;
constexpr std::uint64_t kSlabPlanes = 64;
constexpr std::uint64_t kSlabBytes = std::uint64_t{512} << 20;

/// "voxel (3, 4, 5)", the one at `index` of a box.
std::string voxel_name(const Box& box, std::uint64_t index) {
  return fmt::format("voxel ({}, {}, {})", box.origin.x + index % box.size.x,
                     box.origin.y + index / box.size.x % box.size.y,
                     box.origin.z + index / box.size.x / box.size.y);
}

template <class T>
void reject_negative(const std::string& file, std::span<const std::byte> bytes, const Box* box) {
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    if (value < 0) {
      throw_input_error(file, box != nullptr ? voxel_name(*box, at / sizeof(T)) : "voxels",
                        "labels without a sign",
                        fmt::format("the label {} in a volume stored as signed integers",
                                    static_cast<long long>(value)));
    }
  }
}

template <class Float, class Label>
void convert_labels(const std::string& file, std::span<std::byte> bytes, const Box& box) {
  static_assert(sizeof(Float) == sizeof(Label));
  constexpr int kExactBits = std::numeric_limits<Float>::digits;
  constexpr Float kLargest = static_cast<Float>(std::uint64_t{1} << kExactBits);
  for (std::size_t at = 0; at + sizeof(Float) <= bytes.size(); at += sizeof(Float)) {
    Float value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    const bool in_range = value >= 0 && value <= kLargest;  // false for NaN
    const Label label = in_range ? static_cast<Label>(value) : 0;
    if (!in_range || static_cast<Float>(label) != value) {
      throw_input_error(
          file, voxel_name(box, at / sizeof(Float)),
          fmt::format("a label: a whole number from 0 to 2^{}, the largest that is exact in f{}",
                      kExactBits, 8 * sizeof(Float)),
          fmt::format("{}", value));
    }
    std::memcpy(bytes.data() + at, &label, sizeof label);
  }
}

}  // namespace

void throw_input_error(const std::string& file, std::string_view position,
                       std::string_view expected, std::string_view found) {
  throw InputError(fmt::format("{}: {}{}expected {}, found {}", file, position,
                               position.empty() ? "" : ": ", expected, found));
}

void throw_output_error(const std::string& file, std::string_view reason) {
  throw OutputError(fmt::format("{}: cannot write: {}", file, reason));
}

std::string name_of(const StoredType& stored) {
  if (stored.is_float64) return "f64";
  return stored.is_signed ? fmt::format("i{}", 8 * size_of(stored.type))
                          : std::string(name_of(stored.type));
}

std::string_view long_name_of(VoxelType type) {
  switch (type) {
    case VoxelType::kU8:
      return "uint8";
    case VoxelType::kU16:
      return "uint16";
    case VoxelType::kU32:
      return "uint32";
    case VoxelType::kU64:
      return "uint64";
    case VoxelType::kI16:
      return "int16";
    case VoxelType::kF32:
      return "float32";
  }
  return "?";
}

Interpretation interpret(const std::string& file, StoredType stored, std::optional<VolumeKind> hint,
                         std::optional<VolumeKind> stated, FloatLabels floats,
                         std::string_view type_name) {
  const bool is_float = stored.is_float64 || stored.type == VoxelType::kF32;
  const bool scalar_by_rule = is_float || stored.type == VoxelType::kI16;
  const VolumeKind by_rule = scalar_by_rule ? VolumeKind::kScalars : VolumeKind::kLabels;
  const VolumeKind kind = hint.value_or(stated.value_or(by_rule));
  const std::string found = type_name.empty() ? name_of(stored) : std::string(type_name);
  if (kind == VolumeKind::kLabels) {
    if (is_float && floats == FloatLabels::kRefused)
      throw_input_error(file, "voxel type", "integer labels", found);
    if (is_float)
      return {size_of(stored.type) == 8 ? VoxelType::kU64 : VoxelType::kU32, kind, false, true};
    const VoxelType type = stored.type == VoxelType::kI16 ? VoxelType::kU16 : stored.type;
    return {type, kind, stored.is_signed};
  }
  const bool wide = stored.type == VoxelType::kU32 || stored.type == VoxelType::kU64;
  if (wide || (stored.is_signed && stored.type == VoxelType::kU8)) {
    throw_input_error(
        file, "voxel type", "scalars of type u8, u16, i16 or f32",
        fmt::format(
            "{} (if the voxels are labels, say so with --kind labels; else convert them to f32)",
            found));
  }
  return {stored.type, kind, false};
}

Extent check_extent(const std::string& file, std::string_view position,
                    const std::array<std::uint64_t, 3>& size, VoxelType type) {
  std::uint64_t bytes = size_of(type);
  for (const std::uint64_t n : size) {
    const bool fits = n > 0 && bytes <= kMaximumBytes / n;
    if (!fits) {
      throw_input_error(
          file, position, "an extent of at least 1 voxel on every axis and at most 2^48 bytes",
          fmt::format("{}x{}x{} voxels of type {}", size[0], size[1], size[2], name_of(type)));
    }
    bytes *= n;
  }
  return {size[0], size[1], size[2]};
}

Extent check_extent(const std::string& file, std::string_view position,
                    const std::array<std::uint64_t, 3>& step, std::uint64_t count, VoxelType type) {
  const Extent one = check_extent(file, position, step, type);
  if (count > kMaximumBytes / (one.voxels() * size_of(type))) {
    throw_input_error(
        file, position, "a series of at most 2^48 bytes",
        fmt::format("{} steps of {} voxels of type {}", count, to_string(one), name_of(type)));
  }
  return {one.x, one.y, one.z * count};
}

Steps check_steps(const VolumePath& path, std::string_view position, std::uint64_t stored) {
  if (!path.steps) return {0, std::max<std::uint64_t>(stored, 1)};
  const auto [first, end] = *path.steps;
  const std::string found = end ? fmt::format("[{}:{}]", first, *end) : fmt::format("[{}]", first);
  if (stored == 0)
    throw_input_error(path.file, position, "no step, since this is a single volume", found);
  const bool inside = end ? first < *end && *end <= stored : first < stored;
  if (!inside) {
    throw_input_error(
        path.file, position,
        fmt::format(
            "a step of this series as [T], T from 0 to {}, or steps [A:B] with 0 <= A < B <= {}",
            stored - 1, stored),
        found);
  }
  return {first, end ? *end - first : 1};
}

void reject_negative_voxels(const std::string& file, std::span<const std::byte> voxels,
                            std::size_t width, const Box* box) {
  switch (width) {
    case 1:
      return reject_negative<std::int8_t>(file, voxels, box);
    case 2:
      return reject_negative<std::int16_t>(file, voxels, box);
    case 4:
      return reject_negative<std::int32_t>(file, voxels, box);
    default:
      return reject_negative<std::int64_t>(file, voxels, box);
  }
}

void labels_from_floats(const std::string& file, std::span<std::byte> voxels, std::size_t width,
                        const Box& box) {
  if (width == sizeof(float)) return convert_labels<float, std::uint32_t>(file, voxels, box);
  convert_labels<double, std::uint64_t>(file, voxels, box);
}

bool has_ending(std::string_view name, std::string_view ending) {
  if (name.size() < ending.size()) return false;
  return std::equal(
      ending.begin(), ending.end(), name.end() - static_cast<std::ptrdiff_t>(ending.size()),
      [](char small, char any) { return small == std::tolower(static_cast<unsigned char>(any)); });
}

std::optional<double> metres_of(std::string_view unit) {
  struct Unit {
    std::string_view name;
    double metres;
  };
  static constexpr std::array kUnits{
      Unit{"m", 1.0},           Unit{"meter", 1.0},       Unit{"cm", 1e-2},
      Unit{"mm", 1e-3},         Unit{"millimeter", 1e-3}, Unit{"um", 1e-6},
      Unit{"\u00b5m", 1e-6},    Unit{"\u03bcm", 1e-6},    Unit{"micron", 1e-6},
      Unit{"micrometer", 1e-6}, Unit{"microns", 1e-6},    Unit{"nm", 1e-9},
      Unit{"nanometer", 1e-9},  Unit{"angstrom", 1e-10},
  };
  const auto found =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return u.name == unit; });
  return found == kUnits.end() ? std::nullopt : std::optional(found->metres);
}

void take_slabs(const VolumeSource& source,
                const std::function<void(std::span<const std::byte>)>& take) {
  const std::uint64_t depth = std::min(planes_within(kSlabBytes, source.info()), kSlabPlanes);
  for_each_slab(source, depth,
                [&](std::uint64_t, std::span<const std::byte> voxels) { take(voxels); });
}

}  // namespace cvr::volumes
