#include "experiments/config/dataset_keys.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "volumes/generators/generator.hpp"
#include "volumes/io/io.hpp"

namespace cvr::experiments {

namespace {

constexpr std::uint64_t kMostAxis = std::uint64_t{1} << 40;
constexpr double kAny = 1e300;

const volumes::GeneratorInfo& find_generator(std::string_view kind) {
  return *std::ranges::find(volumes::all_generators(), kind, &volumes::GeneratorInfo::kind);
}

Shape<std::string> generator_kind() {
  std::vector<std::string> kinds;
  for (const auto& generator : volumes::all_generators()) kinds.emplace_back(generator.kind);
  const std::string words = fmt::format("one of {}", fmt::join(kinds, ", "));
  return one_word(std::move(kinds), words);
}

Shape<std::map<std::string, double>> generator_parameters() {
  return {[](const YamlValue& value) {
            std::map<std::string, double> parameters;
            for (const auto& [name, number] : value.entries())
              parameters[name.text()] = number.number(-kAny, kAny);
            return parameters;
          },
          "a map of names and numbers",
          R"({"type": "object", "additionalProperties": {"type": "number"}})"};
}

Shape<volumes::Extent> extent_shape() {
  const auto axes = exactly<3>(whole_number(1, kMostAxis), "three extents [x, y, z]");
  return {[read = axes.read](const YamlValue& value) {
            const auto [x, y, z] = read(value);
            const volumes::Extent extent{x, y, z};
            if (is_too_large(extent)) {
              value.reject(fmt::format("expected at most {} voxels in all, found {}", kMostVoxels,
                                       to_string(extent)));
            }
            return extent;
          },
          axes.values, axes.schema};
}

Shape<std::string> axes_shape() {
  return {[](const YamlValue& value) {
            if (!are_axes(value.text("axes"))) value.expected(kAxesExplained);
            return value.text();
          },
          kAxesExplained, R"({"type": "string", "pattern": "^[tzyxc]{3,5}$"})"};
}

Shape<std::string> hash_shape() {
  const std::string words = "16 hexadecimal digits or unknown";
  return {[words](const YamlValue& value) {
            std::string digits = value.text();
            if (digits == "unknown") return std::string();
            const bool sound =
                digits.size() == 16 &&
                std::ranges::all_of(digits, [](unsigned char c) { return std::isxdigit(c) != 0; });
            if (!sound) value.expected(words);
            return digits;
          },
          words, std::string(kTextSchema)};
}

Shape<volumes::VolumeKind> kind_shape() {
  return named(volumes::volume_kind_from_name, {"labels", "scalars"}, "labels or scalars");
}

Shape<volumes::VoxelType> type_shape() {
  return named(volumes::voxel_type_from_name, {"u8", "u16", "u32", "u64", "i16", "f32"},
               "u8, u16, u32, u64, i16 or f32");
}

/// A path of a volume. One that is not absolute begins at the folder of `document`, unless it begins
/// with the data folder's variable.
Shape<std::string> file_shape(const std::string& document) {
  return {[document](const YamlValue& value) {
            std::string name = value.text("the path of a volume");
            if (name.empty()) value.expected("the path of a volume");
            const bool in_data_folder = name.starts_with(kDataVariable);
            if (name.find('$', in_data_folder ? kDataVariable.size() : 0) != std::string::npos ||
                name.starts_with('~')) {
              value.expected(fmt::format("a path with no other variable than {} at its beginning",
                                         kDataVariable));
            }
            if (in_data_folder) return name;
            const auto folder = std::filesystem::path(document).parent_path();
            return (folder / name).lexically_normal().string();
          },
          "a path", std::string(kTextSchema)};
}

Shape<Dataset> described(const Catalogue& catalogue) {
  return {[&catalogue](const YamlValue& value) {
            const std::string name = value.text("the name of a data set");
            const Dataset* found = catalogue.find(name);
            if (found == nullptr) {
              value.expected("the name of a data set ('list datasets' names them)" +
                             did_you_mean(name, catalogue.names()));
            }
            return *found;
          },
          "the name of a data set", std::string(kTextSchema)};
}

/// seed and parameters of a draft's generator; what its kind is called differs.
template <class Draft>
void add_generator_keys(std::vector<Key<Draft>>& keys, GeneratorChoice Draft::*generator) {
  keys.push_back(key<Draft>(
      "seed", whole_number(0, UINT64_MAX),
      [generator](Draft& d, std::uint64_t seed) { (d.*generator).seed = seed; }, "1",
      "Seed of the generator; the same seed makes the same voxels everywhere."));
  keys.push_back(key<Draft>(
      "parameters", generator_parameters(),
      [generator](Draft& d, std::map<std::string, double> p) {
        (d.*generator).parameters = std::move(p);
      },
      "the generator's own",
      "Parameters of the generator; one that is not named has its default."));
}

template <class Draft, class T, class M>
Key<Draft> dataset_key(std::string name, M Dataset::*member, const Shape<T>& shape,
                       std::string fallback, std::string sentence) {
  return key<Draft>(
      std::move(name), shape,
      [member](Draft& d, T value) {
        if constexpr (std::is_arithmetic_v<M>)
          d.dataset.*member = static_cast<M>(value);
        else
          d.dataset.*member = std::move(value);
      },
      std::move(fallback), std::move(sentence));
}

template <class Draft>
Key<Draft> voxel_size_key() {
  return dataset_key<Draft>(
      "voxel_size", &Dataset::voxel_size,
      exactly<3>(real_number(1e-300, kAny), "a list of three sizes [x, y, z]"), "",
      "In voxel_unit, of a volume that says none itself.");
}

template <class Draft>
Key<Draft> voxel_unit_key() {
  return dataset_key<Draft>(
      "voxel_unit", &Dataset::voxel_unit, one_text(), "",
      "Such as nm, um or mm; without one the proportions of voxel_size alone count.");
}

struct StandIn {
  GeneratorChoice generator;
};

std::vector<Key<StandIn>> stand_in_keys() {
  std::vector<Key<StandIn>> keys{required(key<StandIn>(
      "generator", generator_kind(),
      [](StandIn& s, std::string kind) { s.generator.kind = std::move(kind); }, "",
      "Kind of the generator."))};
  add_generator_keys(keys, &StandIn::generator);
  return keys;
}

const char* const kAxesSentence =
    "Axes of the file in the order in which its format lists them (HDF5: slowest first), for "
    "instance tzyxc; files only.";
const char* const kExternalSentence =
    "Whether files outside the volume's own folder that it names may be read; files only.";

}  // namespace

std::vector<Key<DescriptionDraft>> description_keys(const std::string& catalogue_path) {
  using D = DescriptionDraft;
  const auto text = [](std::string name, std::string Dataset::*member, std::string sentence) {
    return dataset_key<D>(std::move(name), member, one_text(), "", std::move(sentence));
  };
  std::vector<Key<D>> keys{
      required(text("title", &Dataset::title, "One line for tables and lists.")),
      text("citation", &Dataset::citation, "The publication that describes the data."),
      text("licence", &Dataset::licence, "Of the data; unknown where nothing is said."),
      text("origin", &Dataset::origin, "Where the public original lies, or what made it."),
      required(dataset_key<D>("kind", &Dataset::kind, kind_shape(), "", "What voxels mean.")),
      required(
          dataset_key<D>("type", &Dataset::type, type_shape(), "", "Type of the stored voxels.")),
      required(key<D>(
          "extent", exactly<3>(whole_number(1, kMostAxis), "a list of three extents [x, y, z]"),
          [](D& d, std::array<std::uint64_t, 3> e) {
            d.dataset.extent = d.dataset.full_extent = {e[0], e[1], e[2]};
          },
          "", "In voxels; of a series the extent of one time step.")),
      dataset_key<D>("steps", &Dataset::time_steps, whole_number(1, UINT64_MAX), "1",
                     "Number of time steps of a series; 1 also for one step, which the file's name "
                     "chooses by a suffix [T]. [A:B] names steps A to B - 1."),
      voxel_size_key<D>(),
      voxel_unit_key<D>(),
      dataset_key<D>("labels", &Dataset::labels, whole_number(1, UINT64_MAX), "",
                     "Number of distinct labels, 0 included; label volumes only."),
      dataset_key<D>("hash", &Dataset::hash, hash_shape(), "unknown",
                     "XXH3-64 of the file's bytes; files only."),
      dataset_key<D>("file", &Dataset::file, file_shape(catalogue_path), "",
                     "A volume file as the readers take it (a name, or a name and a data set); "
                     "${CVRBENCH_DATA} at its beginning is the data folder, and a path that is not "
                     "absolute begins at this folder. It may be absent: its cells are then rows "
                     "with the status data-missing."),
      dataset_key<D>("axes", &Dataset::axes, axes_shape(), "as the file says", kAxesSentence),
      dataset_key<D>("allow_external", &Dataset::allow_external, yes_or_no(), "false",
                     kExternalSentence),
      text("package", &Dataset::package, "The Debian package that the file comes from."),
      key<D>(
          "generator", generator_kind(),
          [](D& d, std::string kind) { d.generator.kind = std::move(kind); }, "",
          "In place of a file: the kind of generator that makes the volume, at `extent` times the "
          "scale of the configuration."),
  };
  add_generator_keys(keys, &D::generator);
  keys.push_back(text("stand_in_for", &Dataset::stand_in_for,
                      "The data set that the generated one stands in for; tables say so."));
  const auto stand_in = map_of(stand_in_keys(), "a map of generator, seed and parameters");
  keys.push_back(key<D>(
      "stand_in", stand_in, [](D& d, StandIn s) { d.stand_in = std::move(s.generator); }, "",
      "What is made, at `extent` times the scale of the configuration, where the file is absent."));
  return keys;
}

Dataset read_description(const std::string& name, const YamlValue& value,
                         const std::string& catalogue_path) {
  DescriptionDraft draft;
  read_keys(value, description_keys(catalogue_path), draft);
  Dataset d = std::move(draft.dataset);
  d.name = name;
  const bool generated = !draft.generator.kind.empty();
  if (generated && draft.stand_in) value.expected("either generator or stand_in");
  if (generated) d.generator = draft.generator;
  if (draft.stand_in) {
    d.generator = draft.stand_in;
    d.stand_in_for = name;
  }
  if (d.generator && d.time_steps > 1)
    d.generator->parameters["steps"] = static_cast<double>(d.time_steps);
  if (d.file.empty() && (!d.axes.empty() || d.allow_external))
    value.expected("axes and allow_external only beside a file");
  if (!d.voxel_unit.empty() && !d.voxel_size) value.expected("voxel_unit only beside a voxel_size");
  if (is_too_large(d.extent, d.time_steps))
    value.reject(fmt::format("expected at most {} voxels in all, found {} in {} steps", kMostVoxels,
                             to_string(d.extent), d.time_steps));
  if (d.file.empty() == !generated)
    value.expected("either a file (with or without a stand_in) or a generator");
  return d;
}

namespace {

const char* const kScaleSentence =
    "Side lengths of the generated volume over those of the described one.";
const char* const kBytesSentence =
    "Bytes per voxel of the original by which published rates are counted.";

Dataset read_choice(const YamlValue& value, const Catalogue& catalogue) {
  ChoiceDraft draft;
  read_keys(value, choice_keys(catalogue), draft);
  Dataset dataset = std::move(draft.dataset);
  if ((draft.scale || draft.extent) && !dataset.generator)
    value.reject("expected a scale or extent only for what is generated, found a file");
  if ((draft.axes || draft.allow_external) && dataset.file.empty())
    value.reject("expected axes and allow_external only for a file, found what is generated");
  if (draft.axes) dataset.axes = *draft.axes;
  if (draft.allow_external) dataset.allow_external = *draft.allow_external;
  if (draft.scale) dataset.scale = *draft.scale;
  if (draft.extent) dataset.extent = *draft.extent;
  dataset.bytes_per_voxel = draft.bytes_per_voxel;
  dataset.exchange_axes = draft.exchange_axes;
  return dataset;
}

Dataset read_file(const YamlValue& value, const std::string& config_path) {
  FileDraft draft;
  read_keys(value, file_keys(config_path), draft);
  Dataset dataset = std::move(draft.dataset);
  if (dataset.file.starts_with(kDataVariable))
    value.reject(
        fmt::format("expected a file by its path, found one in {}: describe such a volume "
                    "in configs/datasets",
                    kDataVariable));
  if (!dataset.voxel_unit.empty() && !dataset.voxel_size)
    value.expected("voxel_unit only beside a voxel_size");
  try {
    const auto source =
        volumes::open_volume(dataset.file, {draft.kind, dataset.axes, dataset.allow_external});
    const volumes::VolumeInfo& info = source->info();
    dataset.kind = info.kind;
    dataset.type = info.type;
    dataset.time_steps = info.time_steps;
    dataset.extent = dataset.full_extent = info.step_extent();
  } catch (const InputError& error) {
    value.reject(error.what());
  }
  if (dataset.name.empty()) dataset.name = name_of_file(dataset.file);
  if (dataset.title.empty()) dataset.title = dataset.name;
  return dataset;
}

Dataset read_generated(const YamlValue& value) {
  GeneratedDraft draft;
  read_keys(value, generated_keys(), draft);
  Dataset dataset = std::move(draft.dataset);
  const GeneratorChoice& choice = draft.generator;
  try {
    const auto source =
        volumes::make_generator(choice.kind, {1, 1, 1}, choice.seed, choice.parameters, 1);
    dataset.type = source->info().type;
    dataset.time_steps = source->info().time_steps;
  } catch (const InputError& error) {
    value.reject(error.what());
  }
  const volumes::GeneratorInfo& info = find_generator(choice.kind);
  dataset.full_extent = dataset.extent;
  dataset.kind = info.volume_kind;
  dataset.title = info.summary;
  if (dataset.name.empty())
    dataset.name = fmt::format("{}-{}", choice.kind, to_string(dataset.extent));
  dataset.generator = choice;
  return dataset;
}

}  // namespace

std::vector<Key<ChoiceDraft>> choice_keys(const Catalogue& catalogue) {
  using D = ChoiceDraft;
  return {
      required(key("name", &D::dataset, described(catalogue), "",
                   "A data set of configs/datasets; `cvrbench list datasets` names them.")),
      key("exchange_axes", &D::exchange_axes, zero_or_one(), "0",
          "1 reads the voxels as if x and z were exchanged: a mistake made on purpose."),
      key("axes", &D::axes, axes_shape(), "as described", kAxesSentence),
      key("allow_external", &D::allow_external, yes_or_no(), "as described", kExternalSentence),
      key("scale", &D::scale, real_number(1e-4, 1), "1", kScaleSentence),
      key("extent", &D::extent, extent_shape(), "as described", "Of what is generated, in voxels."),
      key("bytes_per_voxel", &D::bytes_per_voxel, whole_number(1, 8), "of the stored type",
          kBytesSentence),
  };
}

std::vector<Key<FileDraft>> file_keys(const std::string& config_path) {
  using D = FileDraft;
  return {
      required(dataset_key<D>("file", &Dataset::file, file_shape(config_path), "",
                              "A volume file as the readers take it, which says what it holds; a "
                              "path that is not absolute begins at this folder.")),
      dataset_key<D>("name", &Dataset::name, one_text("a name"), "the file's",
                     "What tables call the volume."),
      dataset_key<D>("title", &Dataset::title, one_text(), "the name",
                     "One line for tables and lists."),
      key("kind", &D::kind, kind_shape(), "as the file says",
          "What voxels mean, of files that do not say it."),
      dataset_key<D>("axes", &Dataset::axes, axes_shape(), "as the file says", kAxesSentence),
      dataset_key<D>("allow_external", &Dataset::allow_external, yes_or_no(), "false",
                     kExternalSentence),
      voxel_size_key<D>(),
      voxel_unit_key<D>(),
      dataset_key<D>("bytes_per_voxel", &Dataset::bytes_per_voxel, whole_number(1, 8),
                     "of the stored type", kBytesSentence),
  };
}

std::vector<Key<GeneratedDraft>> generated_keys() {
  using D = GeneratedDraft;
  std::vector<Key<D>> keys{
      required(key<D>(
          "generator", generator_kind(),
          [](D& d, std::string kind) { d.generator.kind = std::move(kind); }, "",
          "Kind of the generator.")),
      required(dataset_key<D>("extent", &Dataset::extent, extent_shape(), "", "In voxels.")),
      dataset_key<D>("name", &Dataset::name, one_text("a name"), "KIND-XxYxZ",
                     "What tables call the volume."),
      dataset_key<D>("scale", &Dataset::scale, real_number(1e-4, 1), "1", kScaleSentence),
      dataset_key<D>("bytes_per_voxel", &Dataset::bytes_per_voxel, whole_number(1, 8),
                     "of the stored type", kBytesSentence),
  };
  add_generator_keys(keys, &D::generator);
  return keys;
}

Shape<Dataset> dataset_shape(const Catalogue& catalogue, const std::string& config_path) {
  const auto name = described(catalogue);
  return {[read_name = name.read, &catalogue, config_path](const YamlValue& value) {
            if (!value.is_map()) return read_name(value);
            for (const auto& [key, unused] : value.entries()) {
              if (key.text() == "generator") return read_generated(value);
              if (key.text() == "file") return read_file(value, config_path);
            }
            return read_choice(value, catalogue);
          },
          "the name of a data set, or a map that chooses one, names a file or generates one",
          schema_of_either(
              schema_of_either(name.schema, schema_of_map(infos_of(choice_keys(catalogue)))),
              schema_of_either(schema_of_map(infos_of(file_keys(config_path))),
                               schema_of_map(infos_of(generated_keys()))))};
}

}  // namespace cvr::experiments
