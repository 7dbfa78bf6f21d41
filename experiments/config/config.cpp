#include "experiments/config/config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <xxhash.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

#include "codecs/registry.hpp"
#include "experiments/config/dataset_keys.hpp"
#include "experiments/config/render_axes.hpp"
#include "experiments/config/table_spec.hpp"
#include "experiments/config/yaml_reader.hpp"
#include "volumes/generators/generator.hpp"

namespace cvr::experiments {

namespace {

constexpr unsigned kMaxThreads = 4096;
constexpr std::uint64_t kMaxCells = 100000;

struct CodecChoice {
  const codecs::Codec* codec;
  codecs::Parameters parameters;
};

struct Block {
  std::vector<std::shared_ptr<const Dataset>> datasets;
  std::vector<CodecChoice> codecs;
  std::vector<Stage> stages;
  std::vector<Threads> threads{{"1", 1}};
  RenderAxes render;
};

std::vector<std::string> codec_ids() {
  std::vector<std::string> ids;
  for (const codecs::Codec* codec : codecs::all_codecs()) ids.emplace_back(codec->traits().id);
  return ids;
}

volumes::Extent read_extent(const YamlValue& value) {
  const auto axes = value.list("three extents [x, y, z]");
  if (axes.size() != 3) value.expected("three extents [x, y, z]");
  constexpr std::uint64_t kMaxAxis = std::uint64_t{1} << 20;
  const volumes::Extent extent{axes[0].integer(1, kMaxAxis), axes[1].integer(1, kMaxAxis),
                               axes[2].integer(1, kMaxAxis)};
  if (is_too_large(extent))
    value.reject(
        fmt::format("expected at most {} voxels in all, found {}", kMostVoxels, to_string(extent)));
  return extent;
}

const Dataset& find_dataset(const YamlValue& value, const Catalogue& catalogue) {
  const std::string name = value.text("the name of a data set");
  const Dataset* found = catalogue.find(name);
  if (found == nullptr) {
    value.expected("the name of a data set ('list datasets' names them)" +
                   did_you_mean(name, catalogue.names()));
  }
  return *found;
}

/// A volume that only this configuration describes.
Dataset read_generated(const YamlValue& value) {
  Dataset dataset;
  GeneratorChoice choice;
  const volumes::GeneratorInfo* info = nullptr;
  value.fields({{"generator",
                 [&](const YamlValue& v) {
                   std::vector<std::string> kinds;
                   choice.kind = v.text("a kind of generator");
                   for (const auto& generator : volumes::all_generators()) {
                     kinds.emplace_back(generator.kind);
                     if (generator.kind == choice.kind) info = &generator;
                   }
                   if (info == nullptr)
                     v.expected(fmt::format("one of {}", fmt::join(kinds, ", ")) +
                                did_you_mean(choice.kind, kinds));
                 },
                 true},
                {"extent", [&](const YamlValue& v) { dataset.extent = read_extent(v); }, true},
                {"seed", [&](const YamlValue& v) { choice.seed = v.integer(0, UINT64_MAX); }},
                {"name", [&](const YamlValue& v) { dataset.name = v.text("a name"); }},
                {"scale", [&](const YamlValue& v) { dataset.scale = v.number(1e-4, 1); }},
                {"bytes_per_voxel",
                 [&](const YamlValue& v) {
                   dataset.bytes_per_voxel = static_cast<unsigned>(v.integer(1, 8));
                 }},
                {"parameters", [&](const YamlValue& v) {
                   for (const auto& [name, number] : v.entries())
                     choice.parameters[name.text()] = number.number(-1e300, 1e300);
                 }}});
  try {
    const auto source =
        volumes::make_generator(choice.kind, {1, 1, 1}, choice.seed, choice.parameters, 1);
    dataset.type = source->info().type;
    dataset.time_steps = source->info().time_steps;
  } catch (const InputError& error) {
    value.reject(error.what());
  }
  dataset.full_extent = dataset.extent;
  dataset.kind = info->volume_kind;
  dataset.title = info->summary;
  if (dataset.name.empty())
    dataset.name = fmt::format("{}-{}", choice.kind, to_string(dataset.extent));
  dataset.generator = choice;
  return dataset;
}

Dataset read_dataset(const YamlValue& value, const Catalogue& catalogue) {
  if (!value.is_map()) return find_dataset(value, catalogue);
  for (const auto& [key, unused] : value.entries()) {
    if (key.text() == "generator") return read_generated(value);
  }
  Dataset dataset;
  std::optional<double> scale;
  std::optional<volumes::Extent> extent;
  std::uint32_t bytes_per_voxel = 0;
  bool exchange_axes = false;
  std::optional<std::string> axes;
  std::optional<bool> allow_external;
  value.fields(
      {{"name", [&](const YamlValue& v) { dataset = find_dataset(v, catalogue); }, true},
       {"exchange_axes", [&](const YamlValue& v) { exchange_axes = v.integer(0, 1) == 1; }},
       {"axes", [&](const YamlValue& v) { axes = read_axes(v); }},
       {"allow_external", [&](const YamlValue& v) { allow_external = read_yes_no(v); }},
       {"scale", [&](const YamlValue& v) { scale = v.number(1e-4, 1); }},
       {"extent", [&](const YamlValue& v) { extent = read_extent(v); }},
       {"bytes_per_voxel",
        [&](const YamlValue& v) { bytes_per_voxel = static_cast<unsigned>(v.integer(1, 8)); }}});
  if ((scale || extent) && !dataset.generator)
    value.reject("expected a scale or extent only for what is generated, found a file");
  if ((axes || allow_external) && dataset.file.empty())
    value.reject("expected axes and allow_external only for a file, found what is generated");
  if (axes) dataset.axes = *axes;
  if (allow_external) dataset.allow_external = *allow_external;
  if (scale) dataset.scale = *scale;
  if (extent) dataset.extent = *extent;
  dataset.bytes_per_voxel = bytes_per_voxel;
  dataset.exchange_axes = exchange_axes;
  return dataset;
}

/// "8", or "8,8,1" from [8, 8, 1].
std::string parameter_text(const YamlValue& value) {
  if (!value.is_list()) return value.text("a value");
  std::vector<std::string> parts;
  for (const YamlValue& part : value.list("numbers")) parts.push_back(part.text("a number"));
  return fmt::format("{}", fmt::join(parts, ","));
}

void read_codec(const YamlValue& value, std::vector<CodecChoice>& choices) {
  const codecs::Codec* codec = nullptr;
  const auto read_id = [&](const YamlValue& v) {
    const std::string id = v.text("the id of a codec");
    codec = codecs::find_codec(id);
    if (codec == nullptr) {
      const auto ids = codec_ids();
      v.expected(
          fmt::format("a codec of this build ({}){}", fmt::join(ids, ", "), did_you_mean(id, ids)));
    }
  };
  if (!value.is_map()) {
    read_id(value);
    choices.push_back({codec, codecs::Parameters::parse(codec->parameters(), {}).value()});
    return;
  }
  struct Axis {
    YamlValue place;
    std::string name;
    std::vector<std::string> values;
  };
  std::vector<Axis> axes;
  value.fields({{"id", read_id, true}, {"parameters", [&](const YamlValue& v) {
                                          for (const auto& [name, values] : v.entries()) {
                                            Axis axis{name, name.text(), {}};
                                            for (const YamlValue& one :
                                                 values.list_or_one("values"))
                                              axis.values.push_back(parameter_text(one));
                                            axes.push_back(std::move(axis));
                                          }
                                        }}});
  // Each axis is checked alone first, so that the error points at it.
  std::vector<std::vector<std::string>> products{{}};
  for (const Axis& axis : axes) {
    std::vector<std::vector<std::string>> longer;
    for (const std::string& one : axis.values) {
      const std::string assignment = axis.name + "=" + one;
      const auto checked =
          codecs::Parameters::parse(codec->parameters(), std::span(&assignment, 1));
      if (!checked)
        axis.place.reject(fmt::format("{}: {}", codec->traits().id, checked.error().message));
    }
    for (const auto& product : products) {
      for (const std::string& one : axis.values) {
        longer.push_back(product);
        longer.back().push_back(axis.name + "=" + one);
      }
    }
    products = std::move(longer);
  }
  for (const auto& product : products) {
    auto parameters = codecs::Parameters::parse(codec->parameters(), product);
    if (!parameters) value.reject(parameters.error().message);
    choices.push_back({codec, std::move(*parameters)});
  }
}

Threads read_threads(const YamlValue& value) {
  if (value.is_scalar() && value.text() == "all")
    return {"all", std::max(1u, std::thread::hardware_concurrency())};
  const auto count = static_cast<unsigned>(value.integer(1, kMaxThreads));
  return {std::to_string(count), count};
}

Block read_block(const YamlValue& value, const Catalogue& catalogue,
                 const std::string& config_path) {
  Block block;
  std::vector<YamlValue::Field> fields{
      {"datasets",
       [&](const YamlValue& v) {
         for (const YamlValue& one : v.list("data sets")) {
           block.datasets.push_back(std::make_shared<Dataset>(read_dataset(one, catalogue)));
         }
       },
       true},
      {"codecs",
       [&](const YamlValue& v) {
         if (v.is_scalar() &&
             (v.text() == "all" || v.text() == "lossless" || v.text() == "lossy")) {
           for (const codecs::Codec* codec : codecs::all_codecs()) {
             if (v.text() != "all" && codec->traits().lossless != (v.text() == "lossless"))
               continue;
             block.codecs.push_back(
                 {codec, codecs::Parameters::parse(codec->parameters(), {}).value()});
           }
           return;
         }
         for (const YamlValue& one : v.list("codecs, or all, lossless or lossy"))
           read_codec(one, block.codecs);
       },
       true},
      {"stages",
       [&](const YamlValue& v) {
         for (const YamlValue& one : v.list("stages")) {
           const auto stage = stage_from_name(one.text("a stage"));
           if (!stage) {
             std::vector<std::string> names;
             for (const Stage known : kStages) names.emplace_back(name_of(known));
             one.expected("encode, decode, random-access or render" +
                          did_you_mean(one.text(), names));
           }
           block.stages.push_back(*stage);
         }
       },
       true},
      {"threads", [&](const YamlValue& v) {
         block.threads.clear();
         for (const YamlValue& one : v.list_or_one("thread counts"))
           block.threads.push_back(read_threads(one));
       }}};
  for (YamlValue::Field& field : block.render.fields(config_path))
    fields.push_back(std::move(field));
  value.fields(fields);
  block.render.check(value, std::ranges::find(block.stages, Stage::kRender) != block.stages.end());
  return block;
}

TestFault read_fault(const YamlValue& value) {
  TestFault fault;
  value.fields(
      {{"fault",
        [&](const YamlValue& v) {
          fault.fault = v.text();
          static constexpr std::array kFaults{"crash", "hang", "oom", "mismatch", "device-lost"};
          if (std::ranges::find(kFaults, fault.fault) == kFaults.end())
            v.expected("crash, hang, oom, mismatch or device-lost");
        },
        true},
       {"codec", [&](const YamlValue& v) { fault.codec = v.text(); }},
       {"stage", [&](const YamlValue& v) { fault.stage = v.text(); }}});
  return fault;
}

/// Keys with simple values, which --set may name.
std::vector<YamlValue::Field> simple_fields(Config& config) {
  return {
      {"title", [&](const YamlValue& v) { config.title = v.text("a title"); }},
      {"scale", [&](const YamlValue& v) { config.scale = v.number(1e-4, 1); }},
      {"rounds", [&](const YamlValue& v) { config.rounds = v.integer(1, 100000); }},
      {"max_rounds", [&](const YamlValue& v) { config.max_rounds = v.integer(1, 1000000); }},
      {"target_interval",
       [&](const YamlValue& v) { config.target_interval = v.number(1e-6, 1e6); }},
      {"timeout_s", [&](const YamlValue& v) { config.timeout_s = v.number(0.01, 1e7); }},
      {"together", [&](const YamlValue& v) { config.together = v.integer(1, 1000000); }},
      {"memory_limit_gib",
       [&](const YamlValue& v) { config.memory_limit_gib = v.number(0.001, 1e6); }},
      {"seed", [&](const YamlValue& v) { config.seed = v.integer(0, UINT64_MAX); }},
      {"device", [&](const YamlValue& v) { config.device = v.text("an index, a name or a type"); }},
      {"lods",
       [&](const YamlValue& v) {
         config.lods.clear();
         if (v.is_scalar() && v.text() == "all") return;
         for (const YamlValue& one : v.list("levels, or all"))
           config.lods.push_back(static_cast<unsigned>(one.integer(0, 31)));
       }},
  };
}

void apply_setting(const std::string& setting, Config& config) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos)
    throw InputError(fmt::format("--set {}: expected key=value, found no '='", setting));
  const std::string key = setting.substr(0, equals);
  const auto fields = simple_fields(config);
  const auto field = std::ranges::find(fields, key, &YamlValue::Field::key);
  if (field == fields.end()) {
    std::vector<std::string> keys;
    for (const auto& f : fields) keys.push_back(f.key);
    throw InputError(fmt::format("--set {}: expected one of the keys {}, found '{}'{}", setting,
                                 fmt::join(keys, ", "), key, did_you_mean(key, keys)));
  }
  field->read(YamlValue::from_text(setting.substr(equals + 1), "--set " + key));
}

/// The threads of such cells are those that prepare the picture, as many as there are cores; no
/// time depends on them.
template <class Add>
void add_render_cells(const Block& block, const std::shared_ptr<const Dataset>& dataset,
                      const CodecChoice& choice, const std::string& device, const Add& add) {
  const auto& traits = choice.codec->traits();
  const Threads all{"all", std::max(1u, std::thread::hardware_concurrency())};
  for (RenderChoice& render : block.render.choices(choice.parameters, dataset->kind, device)) {
    add({dataset, std::string(traits.id), traits.version, choice.parameters, Stage::kRender, all,
         std::move(render)});
  }
}

std::vector<Cell> expand(const std::vector<Block>& blocks, const Config& config) {
  std::vector<Cell> cells;
  std::set<std::string> seen;
  const auto add = [&](Cell cell) {
    if (seen.insert(cell.row_key()).second) cells.push_back(std::move(cell));
    if (cells.size() > kMaxCells)
      throw InputError(fmt::format("{}: expected at most {} cells", config.path, kMaxCells));
  };
  for (const Block& block : blocks) {
    for (const auto& described : block.datasets) {
      auto dataset = described;
      if (config.scale && dataset->generator) {
        auto scaled = std::make_shared<Dataset>(*dataset);
        scaled->scale = *config.scale;
        dataset = scaled;
      }
      for (const Stage stage : block.stages) {
        if (stage == Stage::kRender) {
          for (const CodecChoice& choice : block.codecs)
            add_render_cells(block, dataset, choice, config.device, add);
          continue;
        }
        for (const Threads& threads : block.threads) {
          if (stage != Stage::kRandomAccess)
            add({dataset, std::string(kMemcpy), 1, {}, stage, threads});
          for (const CodecChoice& choice : block.codecs) {
            const auto& traits = choice.codec->traits();
            add({dataset, std::string(traits.id), traits.version, choice.parameters, stage,
                 threads});
          }
        }
      }
    }
  }
  return cells;
}

/// Tables and claims are found by their names.
void require_names_once(const YamlValue& root, const Config& config) {
  std::set<std::string> tables, claims;
  for (const TableSpec& table : config.tables) {
    if (!tables.insert(table.name).second)
      root.reject(fmt::format("expected tables of different names, found '{}' twice", table.name));
  }
  for (const ClaimSpec& claim : config.claims) {
    if (!claims.insert(claim.name).second)
      root.reject(fmt::format("expected claims of different names, found '{}' twice", claim.name));
  }
}

std::string hash_config(const std::string& path, const std::vector<std::string>& settings) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  for (const std::string& setting : settings) text << '\n' << setting;
  const std::string all = text.str();
  return fmt::format("{:016x}", XXH3_64bits(all.data(), all.size()));
}

}  // namespace

Config read_config(const std::string& path, const Catalogue& catalogue,
                   const std::vector<std::string>& settings, MetricNames metrics) {
  Config config;
  config.path = path;
  std::vector<Block> blocks;
  const YamlValue root = YamlValue::from_file(path);
  auto fields = simple_fields(config);
  fields.push_back({"matrix",
                    [&](const YamlValue& v) {
                      for (const YamlValue& one : v.list("blocks"))
                        blocks.push_back(read_block(one, catalogue, path));
                    },
                    true});
  fields.push_back({"tables", [&](const YamlValue& v) {
                      for (const YamlValue& one : v.list("tables"))
                        config.tables.push_back(read_table(one, path, metrics));
                    }});
  fields.push_back({"claims", [&](const YamlValue& v) {
                      for (const YamlValue& one : v.list("claims"))
                        config.claims.push_back(read_claim(one, path, metrics));
                    }});
  fields.push_back({"test_fault", [&](const YamlValue& v) { config.test_fault = read_fault(v); }});
  root.fields(fields);
  require_names_once(root, config);
  std::set<std::string> set_keys;
  for (const std::string& setting : settings) {
    if (!set_keys.insert(setting.substr(0, setting.find('='))).second)
      throw InputError(fmt::format("--set {}: expected each key once", setting));
    apply_setting(setting, config);
  }
  if (config.max_rounds == 0) config.max_rounds = 3 * config.rounds;
  if (config.max_rounds < config.rounds) {
    root.reject(
        fmt::format("expected max_rounds of at least rounds ({}), found {}: raise max_rounds, or "
                    "leave it out for three times rounds",
                    config.rounds, config.max_rounds));
  }
  config.hash = hash_config(path, settings);
  config.cells = expand(blocks, config);
  return config;
}

void choose_device(Config& config, const std::string& device) {
  config.device = device;
  for (Cell& cell : config.cells) {
    if (cell.render) cell.render->device = device;
  }
}

}  // namespace cvr::experiments
