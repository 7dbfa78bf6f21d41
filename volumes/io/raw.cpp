// Raw voxels, x fastest, beside a sidecar in YAML: FILE.raw and FILE.raw.yaml.
//
//   extent: [512, 256, 128]      x, y, z of a step; FILE.raw must have offset_bytes + steps * X * Y * Z * bytes per voxel, exactly
//   steps: 1                     optional: time steps of a series, one behind the other
//   type: u32                    u8, u16, u32, u64, i16, f32
//   kind: labels                 optional: labels or scalars; f32 labels must be whole numbers and are read as u32
//   voxel_size: [8, 8, 40]       optional: along x, y, z
//   voxel_unit: nm               optional
//   offset: [0, 0, 0]            optional: where the first voxel lies, in voxel_unit
//   byte_order: little           optional: little (default) or big
//   offset_bytes: 0              optional
//   name, source, licence        optional texts
//
// The rules of configurations hold: one document, each key once, no other keys. The file is mapped:
// data() of a little-endian file is the mapping itself.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <filesystem>
#include <limits>
#include <optional>

#include "volumes/io/named_file.hpp"
#include "volumes/io/stored_axes.hpp"
#include "volumes/io/yaml.hpp"

namespace cvr::volumes {

namespace {

constexpr std::uint64_t kLargest = std::uint64_t{1} << 48;

std::string sidecar_name(const std::string& file) { return file + ".yaml"; }

struct Sidecar {
  std::vector<std::uint64_t> extent;  ///< x, y, z
  std::optional<std::uint64_t> steps;
  VoxelType type = VoxelType::kU8;
  std::optional<VolumeKind> kind;
  std::vector<double> voxel_size{1, 1, 1}, offset{0, 0, 0};  ///< along the axes of `extent`
  std::string voxel_unit;
  bool big_endian = false;
  std::uint64_t offset_bytes = 0;
  Provenance provenance;
};

std::vector<YamlValue> three(const YamlValue& value, std::string_view what) {
  if (!value.is_list()) value.expected(what);
  std::vector<YamlValue> values = value.list(what);
  if (values.size() != 3)
    value.reject(fmt::format("expected {}, found {} values", what, values.size()));
  return values;
}

std::vector<double> three_numbers(const YamlValue& value, std::string_view what, bool positive) {
  std::vector<double> numbers;
  for (const YamlValue& number : three(value, what)) {
    numbers.push_back(
        number.number(std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()));
    if (positive && numbers.back() <= 0) number.expected(what);
  }
  return numbers;
}

/// A text of which `parse` knows the meaning.
template <class Parse>
auto named(const YamlValue& value, Parse parse, std::string_view what) {
  const auto result = parse(value.text(what));
  if (!result) value.expected(what);
  return *result;
}

Sidecar read_sidecar(const std::string& file, const OpenOptions& options) {
  const std::string name = sidecar_name(file);
  std::error_code ignored;
  if (!std::filesystem::exists(name, ignored)) {
    throw_input_error(
        file, "",
        fmt::format("a sidecar {} beside it, with the keys extent: [X, Y, Z] and type", name),
        "none");
  }
  Sidecar sidecar;
  const auto number = [](const YamlValue& value) { return value.integer(0, kLargest); };
  YamlValue::from_file(
      named_file(file, "sidecar", std::filesystem::path(name).filename().string(), options))
      .fields({
          {"extent",
           [&](const YamlValue& v) {
             for (const YamlValue& n : three(v, "three sizes [x, y, z]"))
               sidecar.extent.push_back(number(n));
           },
           true},
          {"steps", [&](const YamlValue& v) { sidecar.steps = v.integer(1, kLargest); }},
          {"type",
           [&](const YamlValue& v) {
             sidecar.type = named(v, voxel_type_from_name, "u8, u16, u32, u64, i16 or f32");
           },
           true},
          {"kind",
           [&](const YamlValue& v) {
             sidecar.kind = named(v, volume_kind_from_name, "labels or scalars");
           }},
          {"voxel_size",
           [&](const YamlValue& v) {
             sidecar.voxel_size = three_numbers(v, "three positive numbers [x, y, z]", true);
           }},
          {"voxel_unit", [&](const YamlValue& v) { sidecar.voxel_unit = v.any_text(); }},
          {"offset",
           [&](const YamlValue& v) {
             sidecar.offset = three_numbers(v, "three numbers [x, y, z]", false);
           }},
          {"byte_order",
           [&](const YamlValue& v) {
             const std::string order = v.text("little or big");
             if (order != "little" && order != "big") v.expected("little or big");
             sidecar.big_endian = order == "big";
           }},
          {"offset_bytes", [&](const YamlValue& v) { sidecar.offset_bytes = number(v); }},
          {"name", [&](const YamlValue& v) { sidecar.provenance.name = v.any_text(); }},
          {"source", [&](const YamlValue& v) { sidecar.provenance.source = v.any_text(); }},
          {"licence", [&](const YamlValue& v) { sidecar.provenance.licence = v.any_text(); }},
      });
  return sidecar;
}

}  // namespace

std::unique_ptr<VolumeSource> open_raw(const VolumePath& path, const OpenOptions& options) {
  MappedFile file(path.file, MappedFile::Least::kBegin);
  const std::string sidecar_path = sidecar_name(path.file);
  const Sidecar sidecar = read_sidecar(path.file, options);
  const Interpretation meaning =
      interpret(path.file, {sidecar.type, sidecar.type == VoxelType::kI16}, options.kind,
                sidecar.kind, FloatLabels::kConverted);
  std::vector<std::uint64_t> sizes = sidecar.extent;
  if (sidecar.steps) sizes.push_back(*sidecar.steps);
  const std::string letters = options.axes.empty()
                                  ? std::string("xyzt").substr(0, sizes.size())
                                  : letters_of(sidecar_path, "extent", sizes, options);
  const StoredAxes axes = resolve_axes(sidecar_path, "extent", sizes, letters, meaning.type);
  VolumeInfo info{.extent = {},
                  .type = meaning.type,
                  .kind = meaning.kind,
                  .voxel_size = along_xyz(axes, sidecar.voxel_size, 1),
                  .voxel_unit = sidecar.voxel_unit,
                  .offset = along_xyz(axes, sidecar.offset, 0)};
  ArrayLayout layout{.offset = sidecar.offset_bytes,
                     .big_endian = sidecar.big_endian,
                     .reject_negative = meaning.reject_negative,
                     .whole_numbers = meaning.whole_numbers};
  apply_axes(path, "steps", axes, info, layout);
  const std::uint64_t size = file.size();
  if (layout.offset > size || size - layout.offset != layout.stored_bytes) {
    throw_input_error(
        path.file, "",
        fmt::format("{} + {} bytes as {} says", layout.offset, layout.stored_bytes, sidecar_path),
        fmt::format("{} bytes", size));
  }
  return open_array(std::move(file), info, layout, sidecar.provenance, {path.file, sidecar_path});
}

void write_raw(const VolumePath& path, const VolumeSource& source) {
  const VolumeInfo& info = source.info();
  const Provenance provenance = source.provenance();
  YAML::Emitter yaml;
  yaml << YAML::BeginMap;
  const Extent step = info.step_extent();
  yaml << YAML::Key << "extent" << YAML::Value << YAML::Flow << YAML::BeginSeq << step.x << step.y
       << step.z << YAML::EndSeq;
  if (info.time_steps > 1) yaml << YAML::Key << "steps" << YAML::Value << info.time_steps;
  yaml << YAML::Key << "type" << YAML::Value << std::string(name_of(info.type));
  yaml << YAML::Key << "kind" << YAML::Value << std::string(name_of(info.kind));
  yaml << YAML::Key << "voxel_size" << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const double size : info.voxel_size) yaml << fmt::format("{}", size);
  yaml << YAML::EndSeq;
  if (info.offset != std::array<double, 3>{}) {
    yaml << YAML::Key << "offset" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (const double coordinate : info.offset) yaml << fmt::format("{}", coordinate);
    yaml << YAML::EndSeq;
  }
  const std::array texts{std::pair{"voxel_unit", info.voxel_unit},
                         std::pair{"name", provenance.name}, std::pair{"source", provenance.source},
                         std::pair{"licence", provenance.licence}};
  for (const auto& [key, text] : texts) {
    if (!text.empty()) yaml << YAML::Key << key << YAML::Value << text;
  }
  yaml << YAML::EndMap;

  OutputFile voxels(path.file);
  OutputFile sidecar(sidecar_name(path.file));
  take_slabs(source, [&voxels](std::span<const std::byte> slab) { voxels.write(slab); });
  sidecar.write(std::string_view(yaml.c_str(), yaml.size()));
  sidecar.write("\n");
  OutputFile::commit_pair(voxels, sidecar);
}

}  // namespace cvr::volumes
