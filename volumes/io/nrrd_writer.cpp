// Writes NRRD headers and files, attached or detached; nrrd.hpp says which.
#include <fmt/format.h>

#include <filesystem>

#include "volumes/io/gzip.hpp"
#include "volumes/io/nrrd.hpp"

namespace cvr::volumes {

namespace {

constexpr int kGzipLevel = 6;

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) result += c == '\n' ? "\\n" : c == '\\' ? "\\\\" : std::string(1, c);
  return result;
}

std::string_view type_name(VoxelType type) {
  return type == VoxelType::kF32 ? "float" : long_name_of(type);
}

/// Spacings, or directions and origin where the volume has an offset.
std::string geometry_text(const VolumeInfo& info, bool series) {
  const auto& [x, y, z] = info.voxel_size;
  const std::string& unit = info.voxel_unit;
  if (info.offset == std::array<double, 3>{}) {
    std::string text = fmt::format("spacings: {} {} {}{}\n", x, y, z, series ? " nan" : "");
    if (!unit.empty())
      text += fmt::format("units: \"{0}\" \"{0}\" \"{0}\"{1}\n", unit, series ? " \"\"" : "");
    return text;
  }
  std::string text =
      fmt::format("space dimension: 3\nspace directions: ({},0,0) (0,{},0) (0,0,{}){}\n", x, y, z,
                  series ? " none" : "");
  text += fmt::format("space origin: ({},{},{})\n", info.offset[0], info.offset[1], info.offset[2]);
  if (!unit.empty()) text += fmt::format("space units: \"{0}\" \"{0}\" \"{0}\"\n", unit);
  return text;
}

void write_voxels(OutputFile& output, const VolumeSource& source, NrrdEncoding encoding) {
  const auto plain = [&output](std::span<const std::byte> bytes) { output.write(bytes); };
  if (encoding == NrrdEncoding::kRaw) return take_slabs(source, plain);
  GzipWriter gzip(plain, kGzipLevel);
  take_slabs(source, [&gzip](std::span<const std::byte> slab) { gzip.write(slab); });
  gzip.finish();
}

}  // namespace

std::string nrrd_header_text(const VolumeInfo& info, const Provenance& provenance,
                             NrrdEncoding encoding, const std::string& data_file) {
  // Time is the last axis of a series, without spacing and unit.
  const bool series = info.time_steps > 1;
  const Extent step = info.step_extent();
  std::string text =
      fmt::format("NRRD0004\ntype: {}\ndimension: {}\nsizes: {} {} {}{}\n{}", type_name(info.type),
                  series ? 4 : 3, step.x, step.y, step.z,
                  series ? fmt::format(" {}", info.time_steps) : "", geometry_text(info, series));
  text += fmt::format("kinds: domain domain domain{}\nendian: little\nencoding: {}\n",
                      series ? " list" : "", encoding == NrrdEncoding::kRaw ? "raw" : "gzip");
  if (!data_file.empty()) text += fmt::format("data file: {}\n", data_file);
  text += fmt::format("kind:={}\n", name_of(info.kind));
  if (!provenance.name.empty()) text += fmt::format("name:={}\n", escaped(provenance.name));
  if (!provenance.source.empty()) text += fmt::format("source:={}\n", escaped(provenance.source));
  if (!provenance.licence.empty())
    text += fmt::format("licence:={}\n", escaped(provenance.licence));
  if (data_file.empty()) text += "\n";
  return text;
}

void write_nrrd(const std::string& path, const VolumeSource& source, NrrdEncoding encoding) {
  const VolumeInfo& info = source.info();
  if (info.voxel_unit.find_first_of("\"\n\r") != std::string::npos)
    throw_input_error(path, "units", "a unit without quotation marks and line ends",
                      fmt::format("'{}'", info.voxel_unit));
  OutputFile file(path);
  if (!has_ending(path, ".nhdr")) {
    file.write(nrrd_header_text(info, source.provenance(), encoding, ""));
    write_voxels(file, source, encoding);
    return file.commit();
  }
  OutputFile data(path + (encoding == NrrdEncoding::kRaw ? ".bin" : ".bin.gz"));
  write_voxels(data, source, encoding);
  const std::string data_name = std::filesystem::path(data.path()).filename().string();
  file.write(nrrd_header_text(info, source.provenance(), encoding, data_name));
  OutputFile::commit_pair(data, file);
}

void write_nrrd(const VolumePath& path, const VolumeSource& source) {
  write_nrrd(path.file, source,
             has_ending(path.file, ".nhdr") ? NrrdEncoding::kRaw : NrrdEncoding::kGzip);
}

}  // namespace cvr::volumes
