// NIfTI-1 in one file (.nii) or gzipped (.nii.gz): header struct from nifti1.h, its semantics from the
// comments there.
//
// A header of 348 bytes, 4 bytes of extension flag, voxels from vox_offset with x fastest. dim[0]
// outside 1..7 means that the header and the voxels have the other byte order. 3D, or 4D: a series.
//
// Decisions: values must be stored as they are (scl_slope 0 or 1, scl_inter 0), others are refused rather
// than rounded. The kind follows from the hint, the intent code 1002 (label), the intent name `labels` or
// `scalars` (written by us), else from the type, where u8 without the label intent is a grey value. The voxel
// size is |pixdim| (0: unknown, read as 1), widened through its shortest decimal, so that 0.1f becomes 0.1.
// NIfTI has no nanometre: it is written in micrometres.
#include <fmt/format.h>
#include <nifti/nifti1.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string_view>

#include "volumes/io/array_source.hpp"
#include "volumes/io/format.hpp"
#include "volumes/io/gzip.hpp"

namespace cvr::volumes {

namespace {

constexpr std::size_t kHeaderBytes = 348;
constexpr std::size_t kVoxelOffset = 352;
constexpr int kGzipLevel = 6;
constexpr std::string_view kMagic{"n+1\0", 4};
static_assert(sizeof(nifti_1_header) == kHeaderBytes);

struct TypeCode {
  short code;
  StoredType type;
};
constexpr std::array kTypeCodes{
    TypeCode{DT_UINT8, {VoxelType::kU8, false}},   TypeCode{DT_UINT16, {VoxelType::kU16, false}},
    TypeCode{DT_UINT32, {VoxelType::kU32, false}}, TypeCode{DT_UINT64, {VoxelType::kU64, false}},
    TypeCode{DT_INT16, {VoxelType::kI16, true}},   TypeCode{DT_FLOAT32, {VoxelType::kF32, false}},
    TypeCode{DT_INT8, {VoxelType::kU8, true}},     TypeCode{DT_INT32, {VoxelType::kU32, true}},
    TypeCode{DT_INT64, {VoxelType::kU64, true}},
};

template <class T>
void swap_field(T& field) {
  auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(field);
  std::reverse(bytes.begin(), bytes.end());
  field = std::bit_cast<T>(bytes);
}

/// Exchanges the byte order of the fields that this reader uses.
void swap_header(nifti_1_header& header) {
  swap_field(header.sizeof_hdr);
  for (short& n : header.dim) swap_field(n);
  for (float& size : header.pixdim) swap_field(size);
  swap_field(header.intent_code);
  swap_field(header.datatype);
  swap_field(header.bitpix);
  swap_field(header.vox_offset);
  swap_field(header.scl_slope);
  swap_field(header.scl_inter);
}

struct Header {
  nifti_1_header fields{};
  bool big_endian = false;
};

Header read_header(const std::string& file, std::span<const std::byte> bytes) {
  Header header;
  std::memcpy(&header.fields, bytes.data(), kHeaderBytes);
  nifti_1_header& fields = header.fields;
  header.big_endian = fields.dim[0] < 1 || fields.dim[0] > 7;
  if (header.big_endian) swap_header(fields);
  const std::string_view magic(fields.magic, sizeof fields.magic);
  if (fields.sizeof_hdr != static_cast<int>(kHeaderBytes) || fields.dim[0] < 1 || fields.dim[0] > 7) {
    throw_input_error(file, "byte 0", "a NIfTI-1 header (sizeof_hdr 348, dim[0] 1 to 7)",
                      fmt::format("sizeof_hdr {}, dim[0] {}", fields.sizeof_hdr, fields.dim[0]));
  }
  if (magic != kMagic) {
    const bool pair = magic == std::string_view("ni1\0", 4);
    throw_input_error(file, "byte 344", "the magic n+1 of a single NIfTI-1 file",
                      pair ? "ni1, a pair of files" : "another magic");
  }
  return header;
}

StoredType stored_type(const std::string& file, const nifti_1_header& fields) {
  const auto found = std::find_if(kTypeCodes.begin(), kTypeCodes.end(),
                                  [&](const TypeCode& entry) { return entry.code == fields.datatype; });
  if (found == kTypeCodes.end()) {
    throw_input_error(file, "datatype (byte 70)", "an integer type or float32",
                      fmt::format("code {}", fields.datatype));
  }
  if (fields.bitpix != static_cast<short>(8 * size_of(found->type.type))) {
    throw_input_error(file, "bitpix (byte 72)", fmt::format("{} bits", 8 * size_of(found->type.type)),
                      fmt::format("{}", fields.bitpix));
  }
  return found->type;
}

std::optional<VolumeKind> stated_kind(const nifti_1_header& fields, StoredType type) {
  if (fields.intent_code == NIFTI_INTENT_LABEL) return VolumeKind::kLabels;
  const std::string_view name(fields.intent_name, ::strnlen(fields.intent_name, sizeof fields.intent_name));
  if (const auto kind = volume_kind_from_name(name)) return kind;
  if (type.type == VoxelType::kU8 && !type.is_signed) return VolumeKind::kScalars;
  return std::nullopt;
}

/// (X, Y, Z, T): axes that the header leaves out have one entry.
std::array<std::uint64_t, 4> dimensions(const std::string& file, const nifti_1_header& fields) {
  std::array<std::uint64_t, 4> size{1, 1, 1, 1};
  for (int axis = 1; axis <= fields.dim[0]; ++axis) {
    const short n = fields.dim[axis];
    const bool fits = n >= 1 && (axis <= 4 || n == 1);
    if (!fits) {
      throw_input_error(file, fmt::format("dim[{}] (byte {})", axis, 40 + 2 * axis),
                        axis <= 4 ? "a size of at least 1" : "a size of 1", fmt::format("{}", n));
    }
    if (axis <= 4) size[static_cast<std::size_t>(axis - 1)] = static_cast<std::uint64_t>(n);
  }
  return size;
}

std::uint64_t voxel_offset(const std::string& file, const nifti_1_header& fields) {
  const float offset = fields.vox_offset;
  const bool whole = std::isfinite(offset) && offset == std::floor(offset);
  if (!whole || offset < static_cast<float>(kVoxelOffset) || offset > 1e9f) {
    throw_input_error(file, "vox_offset (byte 108)", "a whole number from 352 to 10^9",
                      fmt::format("{}", offset));
  }
  return static_cast<std::uint64_t>(offset);
}

void check_scaling(const std::string& file, const nifti_1_header& fields) {
  const bool identity = fields.scl_slope == 0 || (fields.scl_slope == 1 && fields.scl_inter == 0);
  if (!identity) {
    throw_input_error(file, "scl_slope (byte 112)", "values stored as they are (slope 0 or 1, intercept 0)",
                      fmt::format("slope {}, intercept {}", fields.scl_slope, fields.scl_inter));
  }
}

/// Metres and name of the spatial unit; 0 where the header says none.
std::pair<double, std::string> unit_of(char xyzt_units) {
  switch (XYZT_TO_SPACE(xyzt_units)) {
    case NIFTI_UNITS_METER:
      return {1.0, "m"};
    case NIFTI_UNITS_MM:
      return {1e-3, "mm"};
    case NIFTI_UNITS_MICRON:
      return {1e-6, "um"};
    default:
      return {0.0, ""};
  }
}

/// The double with the shortest decimal that this float has.
double widened(float value) {
  const std::string text = fmt::format("{}", value);
  double result = 0;
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result;
}

nifti_1_header make_header(const std::string& file, const VolumeInfo& info) {
  nifti_1_header header{};
  header.sizeof_hdr = static_cast<int>(kHeaderBytes);
  header.regular = 'r';
  const Extent step = info.step_extent();
  const std::array size{step.x, step.y, step.z, info.time_steps};
  header.dim[0] = info.time_steps > 1 ? 4 : 3;
  std::fill(header.dim + 4, header.dim + 8, short{1});
  for (std::size_t axis = 0; axis < size.size(); ++axis) {
    if (size[axis] > static_cast<std::uint64_t>(std::numeric_limits<short>::max())) {
      throw_input_error(file, "", "at most 32767 voxels an axis and steps, the limits of NIfTI-1",
                        fmt::format("{} x {} steps", to_string(step), info.time_steps));
    }
    header.dim[axis + 1] = static_cast<short>(size[axis]);
  }
  const auto type = std::find_if(kTypeCodes.begin(), kTypeCodes.end(),
                                 [&](const TypeCode& entry) { return entry.type.type == info.type; });
  header.datatype = type->code;
  header.bitpix = static_cast<short>(8 * size_of(info.type));

  std::array<double, 3> voxel_size = info.voxel_size;
  if (!info.voxel_unit.empty()) {
    const auto metres = metres_of(info.voxel_unit);
    if (!metres)
      throw_input_error(file, "", "a voxel size in m, mm, um or nm",
                        fmt::format("the unit '{}'", info.voxel_unit));
    constexpr std::array kCodes{NIFTI_UNITS_MICRON, NIFTI_UNITS_MM, NIFTI_UNITS_METER};
    const int code = *metres < 1e-4 ? kCodes[0] : *metres < 0.5 ? kCodes[1] : kCodes[2];
    header.xyzt_units = static_cast<char>(code);
    const double ratio = *metres / unit_of(header.xyzt_units).first;
    if (std::fabs(ratio - 1) > 1e-9) {
      for (double& size_on_axis : voxel_size) size_on_axis *= ratio;
    }
  }
  header.pixdim[0] = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) header.pixdim[axis + 1] = static_cast<float>(voxel_size[axis]);
  header.vox_offset = static_cast<float>(kVoxelOffset);
  header.scl_slope = 1;
  header.intent_code = info.kind == VolumeKind::kLabels ? NIFTI_INTENT_LABEL : NIFTI_INTENT_NONE;
  std::memcpy(header.intent_name, name_of(info.kind).data(), name_of(info.kind).size());
  std::memcpy(header.magic, kMagic.data(), kMagic.size());
  return header;
}

}  // namespace

std::unique_ptr<VolumeSource> open_nifti(const VolumePath& path, const OpenOptions& options) {
  MappedFile file(path.file, MappedFile::Least::kBegin);
  const bool gzip = is_gzip(file.bytes());
  std::array<std::byte, kHeaderBytes> start{};
  if (gzip) {
    inflate_range(path.file, file.bytes(), 0, start);
  } else if (file.bytes().size() < start.size()) {
    throw_input_error(path.file, "byte 0", "a NIfTI-1 header of 348 bytes",
                      fmt::format("a file of {} bytes", file.bytes().size()));
  } else {
    std::copy_n(file.bytes().begin(), start.size(), start.begin());
  }
  const Header header = read_header(path.file, start);
  const StoredType stored = stored_type(path.file, header.fields);
  const Interpretation meaning = interpret(path.file, stored, options.kind, stated_kind(header.fields, stored));
  check_scaling(path.file, header.fields);
  const auto size = dimensions(path.file, header.fields);
  const Steps steps = check_steps(path, "dim[4] (byte 48)", header.fields.dim[0] < 4 ? 0 : size[3]);
  VolumeInfo info{
      .extent =
          check_extent(path.file, "dim (byte 40)", {size[0], size[1], size[2]}, steps.count, meaning.type),
      .type = meaning.type,
      .kind = meaning.kind,
      .voxel_unit = unit_of(header.fields.xyzt_units).second,
      .time_steps = steps.count};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float pixel = std::fabs(header.fields.pixdim[axis + 1]);
    if (!std::isfinite(pixel))
      throw_input_error(path.file, "pixdim (byte 76)", "finite voxel sizes", fmt::format("{}", pixel));
    info.voxel_size[axis] = pixel == 0 ? 1 : widened(pixel);
  }
  ArrayLayout layout{
      .offset = voxel_offset(path.file, header.fields) + steps.first * (info.bytes() / steps.count),
      .big_endian = header.big_endian,
      .reject_negative = meaning.reject_negative};
  if (gzip) layout.gzip_start = 0;
  return open_array(std::move(file), info, layout, {});
}

void write_nifti(const VolumePath& path, const VolumeSource& source) {
  const nifti_1_header header = make_header(path.file, source.info());
  std::array<std::byte, kVoxelOffset> start{};
  std::memcpy(start.data(), &header, kHeaderBytes);
  OutputFile output(path.file);
  const auto plain = [&output](std::span<const std::byte> bytes) { output.write(bytes); };
  if (path.file.ends_with(".gz")) {
    GzipWriter gzip(plain, kGzipLevel);
    gzip.write(start);
    for_each_slab(source, [&gzip](std::span<const std::byte> slab) { gzip.write(slab); });
    gzip.finish();
  } else {
    plain(start);
    for_each_slab(source, plain);
  }
  output.commit();
}

}  // namespace cvr::volumes
