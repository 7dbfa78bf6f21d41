// Reads the descriptions of data sets; keys as explained in configs/datasets/paper.yaml.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "experiments/config/dataset_keys.hpp"
#include "experiments/config/datasets.hpp"
#include "experiments/config/yaml_reader.hpp"
#include "volumes/generators/generator.hpp"

namespace cvr::experiments {

namespace {

constexpr std::uint64_t kMaxAxis = std::uint64_t{1} << 40;

void read_generator_kind(const YamlValue& value, GeneratorChoice& choice) {
  choice.kind = value.text("a kind of generator");
  std::vector<std::string> kinds;
  for (const auto& generator : volumes::all_generators()) kinds.emplace_back(generator.kind);
  if (std::ranges::find(kinds, choice.kind) == kinds.end()) {
    value.expected("a kind of generator that this build has" + did_you_mean(choice.kind, kinds));
  }
}

void read_parameters(const YamlValue& value, GeneratorChoice& choice) {
  for (const auto& [name, number] : value.entries())
    choice.parameters[name.text()] = number.number(-1e300, 1e300);
}

GeneratorChoice read_stand_in(const YamlValue& value) {
  GeneratorChoice choice;
  value.fields({{"generator", [&](const YamlValue& v) { read_generator_kind(v, choice); }, true},
                {"seed", [&](const YamlValue& v) { choice.seed = v.integer(0, UINT64_MAX); }},
                {"parameters", [&](const YamlValue& v) { read_parameters(v, choice); }}});
  return choice;
}

/// A relative path begins at the folder of the catalogue, unless it begins with the data folder's
/// variable.
std::string read_file_name(const YamlValue& value, const std::string& catalogue_path) {
  const std::string name = value.text("the path of a volume");
  if (name.empty()) value.expected("the path of a volume");
  const bool in_data_folder = name.starts_with(kDataVariable);
  if (name.find('$', in_data_folder ? kDataVariable.size() : 0) != std::string::npos ||
      name.starts_with('~'))
    value.expected(
        fmt::format("a path with no other variable than {} at its beginning", kDataVariable));
  if (in_data_folder) return name;
  return (std::filesystem::path(catalogue_path).parent_path() / name).lexically_normal().string();
}

Dataset read_dataset(const std::string& name, const YamlValue& value,
                     const std::string& catalogue_path) {
  Dataset d;
  d.name = name;
  GeneratorChoice choice;
  const auto text_into = [](std::string& target) {
    return [&target](const YamlValue& v) { target = v.text(); };
  };
  value.fields({
      {"title", text_into(d.title), true},
      {"citation", text_into(d.citation)},
      {"licence", text_into(d.licence)},
      {"origin", text_into(d.origin)},
      {"kind",
       [&](const YamlValue& v) {
         const auto kind = volumes::volume_kind_from_name(v.text());
         if (!kind) v.expected("labels or scalars");
         d.kind = *kind;
       },
       true},
      {"type",
       [&](const YamlValue& v) {
         const auto type = volumes::voxel_type_from_name(v.text());
         if (!type) v.expected("u8, u16, u32, u64, i16 or f32");
         d.type = *type;
       },
       true},
      {"extent",
       [&](const YamlValue& v) {
         const auto axes = v.list("three extents");
         if (axes.size() != 3) v.expected("a list of three extents [x, y, z]");
         d.extent = {axes[0].integer(1, kMaxAxis), axes[1].integer(1, kMaxAxis),
                     axes[2].integer(1, kMaxAxis)};
         d.full_extent = d.extent;
       },
       true},
      {"steps", [&](const YamlValue& v) { d.time_steps = v.integer(1, UINT64_MAX); }},
      {"voxel_size",
       [&](const YamlValue& v) {
         const auto sizes = v.list("three sizes");
         if (sizes.size() != 3) v.expected("a list of three sizes [x, y, z]");
         d.voxel_size.emplace();
         for (std::size_t axis = 0; axis < 3; ++axis)
           (*d.voxel_size)[axis] = sizes[axis].number(1e-300, 1e300);
       }},
      {"voxel_unit", text_into(d.voxel_unit)},
      {"labels", [&](const YamlValue& v) { d.labels = v.integer(1, UINT64_MAX); }},
      {"hash",
       [&](const YamlValue& v) {
         d.hash = v.text();
         if (d.hash == "unknown") d.hash.clear();
         const bool digits =
             std::ranges::all_of(d.hash, [](unsigned char c) { return std::isxdigit(c) != 0; });
         if (!d.hash.empty() && (d.hash.size() != 16 || !digits))
           v.expected("16 hexadecimal digits or unknown");
       }},
      {"file", [&](const YamlValue& v) { d.file = read_file_name(v, catalogue_path); }},
      {"axes", [&](const YamlValue& v) { d.axes = read_axes(v); }},
      {"allow_external", [&](const YamlValue& v) { d.allow_external = read_yes_no(v); }},
      {"package", text_into(d.package)},
      {"generator", [&](const YamlValue& v) { read_generator_kind(v, choice); }},
      {"seed", [&](const YamlValue& v) { choice.seed = v.integer(0, UINT64_MAX); }},
      {"parameters", [&](const YamlValue& v) { read_parameters(v, choice); }},
      {"stand_in_for", text_into(d.stand_in_for)},
      {"stand_in",
       [&](const YamlValue& v) {
         d.generator = read_stand_in(v);
         d.stand_in_for = name;
       }},
  });
  if (!choice.kind.empty() && d.generator) value.expected("either generator or stand_in");
  if (!choice.kind.empty()) d.generator = choice;
  if (d.generator && d.time_steps > 1)
    d.generator->parameters["steps"] = static_cast<double>(d.time_steps);
  if (d.file.empty() && (!d.axes.empty() || d.allow_external))
    value.expected("axes and allow_external only beside a file");
  if (!d.voxel_unit.empty() && !d.voxel_size) value.expected("voxel_unit only beside a voxel_size");
  if (is_too_large(d.extent, d.time_steps))
    value.reject(fmt::format("expected at most {} voxels in all, found {} in {} steps", kMostVoxels,
                             to_string(d.extent), d.time_steps));
  if (d.file.empty() == choice.kind.empty())
    value.expected("either a file (with or without a stand_in) or a generator");
  return d;
}

}  // namespace

std::string read_axes(const YamlValue& value) {
  if (!are_axes(value.text("axes"))) value.expected(kAxesExplained);
  return value.text();
}

bool read_yes_no(const YamlValue& value) {
  const std::string word = value.text("true or false");
  if (word != "true" && word != "false" && word != "1" && word != "0")
    value.expected("true or false");
  return word == "true" || word == "1";
}

volumes::Extent Dataset::generated_extent() const {
  const auto scaled = [this](std::uint64_t n) {
    return std::max<std::uint64_t>(
        1, static_cast<std::uint64_t>(std::llround(static_cast<double>(n) * scale)));
  };
  return {scaled(extent.x), scaled(extent.y), scaled(extent.z)};
}

Catalogue Catalogue::from_folder(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  }
  if (error || files.empty()) {
    throw InputError(
        fmt::format("{}: expected a folder of data set descriptions (*.yaml), found none", folder));
  }
  std::ranges::sort(files);
  Catalogue catalogue;
  for (const std::string& file : files) catalogue.add_file(file);
  return catalogue;
}

void Catalogue::add_file(const std::string& path) {
  for (const auto& [name, value] : YamlValue::from_file(path).entries()) {
    if (find(name.text()) != nullptr) {
      name.reject(fmt::format("expected a name that no other description has, found '{}' again",
                              name.text()));
    }
    datasets_.push_back(read_dataset(name.text(), value, path));
  }
}

const Dataset* Catalogue::find(const std::string& name) const {
  const auto found = std::ranges::find(datasets_, name, &Dataset::name);
  return found == datasets_.end() ? nullptr : &*found;
}

std::vector<std::string> Catalogue::names() const {
  std::vector<std::string> names;
  for (const Dataset& dataset : datasets_) names.push_back(dataset.name);
  return names;
}

}  // namespace cvr::experiments
