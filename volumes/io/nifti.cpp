// NIfTI-1 in one file (.nii) or gzipped (.nii.gz): header struct from nifti1.h, its semantics from
// the comments there.
//
// A header of 348 bytes, 4 bytes of extension flag, extensions, voxels from vox_offset with x
// fastest to the end of the file. The byte order is the one in which sizeof_hdr is 348. 3D, or 4D:
// a series; axes beyond must have length 1.
//
// Decisions: values must be stored as they are (scl_slope 0 or NaN, which the format and its users
// take for "not scaled", or slope 1 and intercept 0), others are refused rather than rounded. The
// kind follows from the hint, the intent code 1002 (label), the intent name `labels` or `scalars`
// (written by us), else from the type, where u8 without the label intent is a grey value. The voxel
// size is |pixdim| (0: unknown, read as 1), widened through its shortest decimal, so that 0.1f
// becomes 0.1. NIfTI has no nanometre: it is written in micrometres.
//
// Offset: of sform (sform_code > 0), else of qform (qform_code > 0), else none. Where the transform
// runs along the axes of the space, the offset of an axis is the first voxel's coordinate on the
// axis of space that it runs along; oblique transforms take x, y, z as they come. That an axis runs
// backwards or obliquely is not kept. Written, where there is an offset, as both forms with code 1.
#include <fmt/format.h>
#include <nifti/nifti1.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "volumes/io/content.hpp"
#include "volumes/io/gzip.hpp"
#include "volumes/io/nifti_types.hpp"
#include "volumes/io/stored_axes.hpp"

namespace cvr::volumes {

using namespace nifti;

namespace {

constexpr short kMaximumRank = 7;

struct TypeName {
  int code;
  std::string_view name;
};
constexpr std::array kTypeNames{
    TypeName{0, "no type"},       TypeName{1, "one bit per voxel"},
    TypeName{2, "uint8"},         TypeName{4, "int16"},
    TypeName{8, "int32"},         TypeName{16, "float32"},
    TypeName{32, "complex64"},    TypeName{64, "float64"},
    TypeName{128, "RGB24"},       TypeName{256, "int8"},
    TypeName{512, "uint16"},      TypeName{768, "uint32"},
    TypeName{1024, "int64"},      TypeName{1280, "uint64"},
    TypeName{1536, "float128"},   TypeName{1792, "complex128"},
    TypeName{2048, "complex256"}, TypeName{2304, "RGBA32"},
};

/// "float64 (NIfTI code 64)".
std::string type_name(short code) {
  const auto found = std::ranges::find(kTypeNames, int{code}, &TypeName::code);
  return fmt::format("{} (NIfTI code {})",
                     found == kTypeNames.end() ? "an unknown type" : found->name, code);
}

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
  swap_field(header.qform_code);
  swap_field(header.sform_code);
  for (float* field : {&header.quatern_b, &header.quatern_c, &header.quatern_d, &header.qoffset_x,
                       &header.qoffset_y, &header.qoffset_z}) {
    swap_field(*field);
  }
  for (auto* row : {&header.srow_x, &header.srow_y, &header.srow_z})
    for (float& value : *row) swap_field(value);
}

struct Header {
  nifti_1_header fields{};
  bool big_endian = false;
};

Header read_header(const std::string& file, std::span<const std::byte> bytes) {
  Header header;
  std::memcpy(&header.fields, bytes.data(), kHeaderBytes);
  nifti_1_header& fields = header.fields;
  constexpr int kSize = static_cast<int>(kHeaderBytes), kSecondVersion = 540;
  int swapped = fields.sizeof_hdr;
  swap_field(swapped);
  if (fields.sizeof_hdr == kSecondVersion || swapped == kSecondVersion) {
    throw_input_error(file, "byte 0", "a NIfTI-1 header (sizeof_hdr 348)",
                      "NIfTI-2 (sizeof_hdr 540), which is not read: convert it to NIfTI-1, for "
                      "instance with nifti_tool");
  }
  if (fields.sizeof_hdr != kSize && swapped != kSize) {
    throw_input_error(file, "byte 0",
                      "a NIfTI-1 header, which begins with its size 348 in either byte order",
                      describe_content(bytes));
  }
  header.big_endian = fields.sizeof_hdr != kSize;
  if (header.big_endian) swap_header(fields);
  const std::string_view magic(fields.magic, sizeof fields.magic);
  if (magic != kMagic) {
    const bool pair = magic == std::string_view("ni1\0", 4);
    throw_input_error(
        file, "byte 344", "the magic n+1 of a single NIfTI-1 file",
        pair ? "ni1, the header of a pair of files (.hdr, .img): convert it to one .nii file"
             : "another magic, as in Analyze 7.5 or a damaged header");
  }
  if (fields.dim[0] < 1 || fields.dim[0] > kMaximumRank) {
    throw_input_error(file, "dim[0] (byte 40)", "1 to 7 axes",
                      fmt::format("dim[0] {} in a {}-endian header", fields.dim[0],
                                  header.big_endian ? "big" : "little"));
  }
  return header;
}

StoredType stored_type(const std::string& file, const nifti_1_header& fields) {
  const auto found = std::find_if(kTypeCodes.begin(), kTypeCodes.end(), [&](const TypeCode& entry) {
    return entry.code == fields.datatype;
  });
  if (found == kTypeCodes.end()) {
    throw_input_error(file, "datatype (byte 70)", "one integer, float32 or float64 per voxel",
                      type_name(fields.datatype));
  }
  if (fields.bitpix != static_cast<short>(8 * size_of(found->type.type))) {
    throw_input_error(file, "bitpix (byte 72)",
                      fmt::format("{} bits, as the datatype {} has", 8 * size_of(found->type.type),
                                  type_name(fields.datatype)),
                      fmt::format("{}", fields.bitpix));
  }
  return found->type;
}

std::optional<VolumeKind> stated_kind(const nifti_1_header& fields, StoredType type) {
  if (fields.intent_code == NIFTI_INTENT_LABEL) return VolumeKind::kLabels;
  const std::string_view name(fields.intent_name,
                              ::strnlen(fields.intent_name, sizeof fields.intent_name));
  if (const auto kind = volume_kind_from_name(name)) return kind;
  if (type.type == VoxelType::kU8 && !type.is_signed) return VolumeKind::kScalars;
  return std::nullopt;
}

/// Of the axes that the header has, x first.
std::vector<std::uint64_t> dimensions(const std::string& file, const nifti_1_header& fields) {
  std::vector<std::uint64_t> sizes;
  for (int axis = 1; axis <= fields.dim[0]; ++axis) {
    const short n = fields.dim[axis];
    if (n < 1) {
      throw_input_error(file, fmt::format("dim[{}] (byte {})", axis, 40 + 2 * axis),
                        "a size of at least 1", fmt::format("{}", n));
    }
    sizes.push_back(static_cast<std::uint64_t>(n));
  }
  return sizes;
}

/// x y z t; the axes beyond have a length of 1.
std::string letters(const std::string& file, const std::vector<std::uint64_t>& sizes) {
  for (std::size_t axis = 4; axis < sizes.size(); ++axis) {
    if (sizes[axis] == 1) continue;
    throw_input_error(
        file, fmt::format("dim[{}] (byte {})", axis + 1, 42 + 2 * axis),
        "a size of 1, since a volume has one value per voxel (a series along this axis: name "
        "it with --axes, such as xyzct)",
        fmt::format("{}", sizes[axis]));
  }
  return std::string("xyzt---").substr(0, sizes.size());
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
  const float slope = fields.scl_slope, intercept = fields.scl_inter;
  if (std::isnan(slope) || slope == 0 || (slope == 1 && intercept == 0)) return;
  throw_input_error(
      file, "scl_slope, scl_inter (bytes 112, 116)",
      "values stored as they are (slope 0, NaN, or 1 with intercept 0; to keep the stored "
      "values set scl_slope to 0, "
      "else write the scaled ones as float32)",
      fmt::format("slope {}, intercept {}", slope, intercept));
}

/// Extensions lie between header and voxels, each with its size (a multiple of 16) in front.
void check_extensions(const std::string& file, std::span<const std::byte> start, bool big_endian) {
  if (start.size() <= kVoxelOffset || start[kHeaderBytes] == std::byte{0}) return;
  constexpr std::size_t kSmallest = 16;
  for (std::size_t at = kVoxelOffset; start.size() - at >= kSmallest;) {
    std::uint32_t size = 0;
    std::memcpy(&size, start.data() + at, sizeof size);
    if (big_endian) swap_field(size);
    if (size == 0) return;  // what is left is padding
    if (size < kSmallest || size > start.size() - at) {
      throw_input_error(
          file, fmt::format("byte {}", at),
          fmt::format("an extension of 16 to {} bytes before the voxels at vox_offset {}",
                      start.size() - at, start.size()),
          fmt::format("one of {} bytes", size));
    }
    at += size;
  }
}

/// The double with the shortest decimal that this float has.
double widened(float value) {
  const std::string text = fmt::format("{}", value);
  double result = 0;
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result;
}

/// Column i: where axis i runs; column 3: where the first voxel lies.
using Transform = std::array<std::array<double, 4>, 3>;

/// nifti1.h, method 2.
Transform quaternion_transform(const nifti_1_header& fields) {
  const double b = fields.quatern_b, c = fields.quatern_c, d = fields.quatern_d;
  const double a = std::sqrt(std::max(0.0, 1 - (b * b + c * c + d * d)));
  return {{{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c),
            widened(fields.qoffset_x)},
           {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b),
            widened(fields.qoffset_y)},
           {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c,
            widened(fields.qoffset_z)}}};
}

Transform affine_transform(const nifti_1_header& fields) {
  Transform transform{};
  const std::array rows{&fields.srow_x, &fields.srow_y, &fields.srow_z};
  for (std::size_t row = 0; row < rows.size(); ++row)
    for (std::size_t column = 0; column < 4; ++column)
      transform[row][column] = widened((*rows[row])[column]);
  return transform;
}

/// The axis of space along which each axis runs; as they come where one is oblique or two run along
/// the same.
std::array<std::size_t, 3> space_axes(const Transform& transform) {
  constexpr double kStraight =
      1e-4;  // of the length; what quaternions in single precision leave of a zero
  constexpr std::array<std::size_t, 3> kAsTheyCome{0, 1, 2};
  std::array<std::size_t, 3> axes{};
  std::array<bool, 3> taken{};
  for (std::size_t column = 0; column < 3; ++column) {
    const double length =
        std::hypot(transform[0][column], transform[1][column], transform[2][column]);
    std::size_t parts = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      if (!(std::fabs(transform[row][column]) > kStraight * length)) continue;
      axes[column] = row;
      ++parts;
    }
    if (parts != 1 || std::exchange(taken[axes[column]], true)) return kAsTheyCome;
  }
  return axes;
}

/// One per axis of the file.
std::vector<double> offsets(const std::string& file, const nifti_1_header& fields) {
  if (fields.sform_code <= 0 && fields.qform_code <= 0) return {};
  const bool affine = fields.sform_code > 0;
  const Transform transform = affine ? affine_transform(fields) : quaternion_transform(fields);
  const std::array<std::size_t, 3> axes = space_axes(transform);
  std::vector<double> result;
  for (const std::size_t axis : axes) result.push_back(transform[axis][3]);
  if (std::ranges::all_of(result, [](double value) { return std::isfinite(value); })) return result;
  throw_input_error(
      file,
      affine ? "srow_x, srow_y, srow_z (byte 280)" : "qoffset_x, qoffset_y, qoffset_z (byte 268)",
      "finite offsets", fmt::format("{}, {}, {}", result[0], result[1], result[2]));
}

/// One per axis of the file; 0 stands for unknown.
std::vector<double> voxel_sizes(const std::string& file, const nifti_1_header& fields) {
  std::vector<double> sizes;
  for (std::size_t axis = 1; axis <= 3; ++axis) {
    const float pixel = std::fabs(fields.pixdim[axis]);
    if (!std::isfinite(pixel))
      throw_input_error(file, fmt::format("pixdim[{}] (byte {})", axis, 76 + 4 * axis),
                        "a finite voxel size", fmt::format("{}", pixel));
    sizes.push_back(pixel == 0 ? 1 : widened(pixel));
  }
  return sizes;
}

/// The bytes before the voxels, inflated where the file is gzipped.
std::vector<std::byte> bytes_before_voxels(const MappedFile& file, bool gzip, std::uint64_t count) {
  std::vector<std::byte> start;
  if (gzip) {
    check_inflatable(file.path(), file.size(), count);
    start.resize(count);
    inflate_start(file.path(), file.bytes(), start);
  } else if (count <= file.bytes().size()) {
    const auto bytes = file.bytes().first(count);
    start.assign(bytes.begin(), bytes.end());
  }
  return start;
}

Header read_header(const MappedFile& file, bool gzip) {
  std::array<std::byte, kHeaderBytes> start{};
  if (gzip) {
    inflate_start(file.path(), file.bytes(), start);
  } else if (file.bytes().size() < start.size()) {
    throw_input_error(
        file.path(), "byte 0", "a NIfTI-1 header of 348 bytes",
        fmt::format("a file of {} bytes: {}", file.bytes().size(), describe_content(file.bytes())));
  } else {
    std::copy_n(file.bytes().begin(), start.size(), start.begin());
  }
  return read_header(file.path(), start);
}

}  // namespace

std::unique_ptr<VolumeSource> open_nifti(const VolumePath& path, const OpenOptions& options) {
  MappedFile file(path.file, MappedFile::Least::kBegin);
  const bool gzip = is_gzip(file.bytes());
  const Header header = read_header(file, gzip);
  const nifti_1_header& fields = header.fields;
  const StoredType stored = stored_type(path.file, fields);
  const Interpretation meaning =
      interpret(path.file, stored, options.kind, stated_kind(fields, stored),
                FloatLabels::kConverted, type_name(fields.datatype));
  check_scaling(path.file, fields);
  const std::vector<std::uint64_t> sizes = dimensions(path.file, fields);
  constexpr std::string_view kSizes = "dim (byte 40)";
  const StoredAxes axes =
      resolve_axes(path.file, kSizes, sizes,
                   options.axes.empty() ? letters(path.file, sizes)
                                        : letters_of(path.file, kSizes, sizes, options),
                   meaning.type);
  VolumeInfo info{.extent = {},
                  .type = meaning.type,
                  .kind = meaning.kind,
                  .voxel_size = along_xyz(axes, voxel_sizes(path.file, fields), 1),
                  .voxel_unit = unit_of(fields.xyzt_units).second,
                  .offset = along_xyz(axes, offsets(path.file, fields), 0)};
  ArrayLayout layout{.encoding = gzip ? ArrayEncoding::kGzip : ArrayEncoding::kPlain,
                     .offset = voxel_offset(path.file, fields),
                     .big_endian = header.big_endian,
                     .reject_negative = meaning.reject_negative,
                     .whole_numbers = meaning.whole_numbers};
  apply_axes(path, "dim[4] (byte 48)", axes, info, layout);
  check_extensions(path.file, bytes_before_voxels(file, gzip, layout.offset), header.big_endian);
  return open_array(std::move(file), info, layout, {});
}

}  // namespace cvr::volumes
