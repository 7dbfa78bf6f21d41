// Writes NIfTI-1, single files; nifti.cpp says how units and offsets are kept.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "volumes/io/file.hpp"
#include "volumes/io/gzip.hpp"
#include "volumes/io/nifti_types.hpp"

namespace cvr::volumes {

using namespace nifti;

namespace {

constexpr int kGzipLevel = 6;

/// A length as the header keeps it. Throws InputError where single precision moves it by more than
/// a hundredth of a voxel.
float narrowed(const std::string& file, std::string_view what, double value, double voxel_size) {
  constexpr double kHundredth = 0.01;
  const auto narrow = static_cast<float>(value);
  if (std::isfinite(narrow) && std::fabs(narrow - value) <= kHundredth * std::fabs(voxel_size))
    return narrow;
  throw_input_error(
      file, "",
      fmt::format(
          "a {} that 32-bit floats, the only ones of NIfTI-1, keep to a hundredth of a voxel "
          "(NRRD and HDF5 keep it exactly)",
          what),
      fmt::format("{}, which would become {}", value, narrow));
}

double scaled(double value, double ratio) {
  return std::fabs(ratio - 1) > 1e-9 ? value * ratio : value;
}

/// Sets the unit of lengths; the factor from the volume's own unit to it.
double set_unit(const std::string& file, const VolumeInfo& info, nifti_1_header& header) {
  if (info.voxel_unit.empty()) return 1;
  const auto metres = metres_of(info.voxel_unit);
  if (!metres)
    throw_input_error(file, "", "a voxel size in m, mm, um or nm",
                      fmt::format("the unit '{}'", info.voxel_unit));
  constexpr std::array kCodes{NIFTI_UNITS_MICRON, NIFTI_UNITS_MM, NIFTI_UNITS_METER};
  const int code = *metres < 1e-4 ? kCodes[0] : *metres < 0.5 ? kCodes[1] : kCodes[2];
  header.xyzt_units = static_cast<char>(code);
  return *metres / unit_of(header.xyzt_units).first;
}

/// Both forms, with the axes of the volume along those of the space; pixdim is set.
void set_offset(const std::string& file, const std::array<double, 3>& offset,
                nifti_1_header& header) {
  header.qform_code = header.sform_code = NIFTI_XFORM_SCANNER_ANAT;
  const std::array rows{&header.srow_x, &header.srow_y, &header.srow_z};
  const std::array places{&header.qoffset_x, &header.qoffset_y, &header.qoffset_z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    *places[axis] = narrowed(file, "offset", offset[axis], header.pixdim[axis + 1]);
    (*rows[axis])[axis] = header.pixdim[axis + 1];
    (*rows[axis])[3] = *places[axis];
  }
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
      throw_input_error(file, "", "at most 32767 voxels per axis and steps, the limits of NIfTI-1",
                        fmt::format("{} x {} steps", to_string(step), info.time_steps));
    }
    header.dim[axis + 1] = static_cast<short>(size[axis]);
  }
  const auto type = std::find_if(kTypeCodes.begin(), kTypeCodes.end(), [&](const TypeCode& entry) {
    return entry.type.type == info.type;
  });
  header.datatype = type->code;
  header.bitpix = static_cast<short>(8 * size_of(info.type));

  const double ratio = set_unit(file, info, header);
  header.pixdim[0] = 1;
  std::array<double, 3> offset{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = scaled(info.voxel_size[axis], ratio);
    offset[axis] = scaled(info.offset[axis], ratio);
    header.pixdim[axis + 1] = narrowed(file, "voxel size", size, size);
  }
  if (offset != std::array<double, 3>{}) set_offset(file, offset, header);
  header.vox_offset = static_cast<float>(kVoxelOffset);
  header.scl_slope = 1;
  header.intent_code = info.kind == VolumeKind::kLabels ? NIFTI_INTENT_LABEL : NIFTI_INTENT_NONE;
  std::memcpy(header.intent_name, name_of(info.kind).data(), name_of(info.kind).size());
  std::memcpy(header.magic, kMagic.data(), kMagic.size());
  return header;
}

}  // namespace

void write_nifti(const VolumePath& path, const VolumeSource& source) {
  const nifti_1_header header = make_header(path.file, source.info());
  std::array<std::byte, kVoxelOffset> start{};
  std::memcpy(start.data(), &header, kHeaderBytes);
  OutputFile output(path.file);
  const auto plain = [&output](std::span<const std::byte> bytes) { output.write(bytes); };
  if (has_ending(path.file, ".gz")) {
    GzipWriter gzip(plain, kGzipLevel);
    gzip.write(start);
    take_slabs(source, [&gzip](std::span<const std::byte> slab) { gzip.write(slab); });
    gzip.finish();
  } else {
    plain(start);
    take_slabs(source, plain);
  }
  output.commit();
}

}  // namespace cvr::volumes
