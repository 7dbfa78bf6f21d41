// list codecs | datasets | metrics | access-modes | stages | devices | config | rows
#include <fmt/format.h>

#include <algorithm>

#include "codecs/registry.hpp"
#include "experiments/analysis/metrics.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/config/key_documents.hpp"
#include "experiments/config/render_options.hpp"
#include "experiments/results/result.hpp"
#include "experiments/run/load_config.hpp"
#include "experiments/stages/stage_kind.hpp"
#include "gpu/caches/cache.hpp"
#include "gpu/vulkan/device.hpp"

namespace cvr::experiments::cli {

namespace {

Row describe_parameter(const codecs::ParameterSpec& spec) {
  Row p;
  p["name"] = spec.name;
  p["type"] = name_of(spec.type);
  p["default"] = spec.default_value;
  p["range"] = describe_range(spec);
  p["description"] = spec.description;
  return p;
}

Row describe_codec(const codecs::Codec& codec) {
  const codecs::Traits& t = codec.traits();
  Row c;
  c["id"] = t.id;
  c["version"] = t.version;
  c["family"] = t.family;
  c["summary"] = t.summary;
  c["lossless"] = t.lossless;
  c["types"] = Row::array();
  for (const auto type : t.types) c["types"].push_back(name_of(type));
  c["access"] = name_of(t.access);
  c["levels_of_detail"] = t.levels_of_detail;
  c["stored_compressed"] = t.stored_compressed;
  c["gpu_decodable"] = t.gpu_decodable;
  c["gpu_scalars"] = t.gpu_scalars;
  c["parameters"] = Row::array();
  for (const auto& spec : codec.parameters()) c["parameters"].push_back(describe_parameter(spec));
  return c;
}

void list_codecs(bool json) {
  if (json) return print_json(describe_codecs());
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    const codecs::Traits& t = codec->traits();
    fmt::print("{:<15} {}; {}, version {}, access by {}{}\n", t.id, t.summary,
               t.lossless ? "lossless" : "lossy", t.version, name_of(t.access),
               t.levels_of_detail ? ", levels of detail" : "");
    for (const auto& spec : codec->parameters()) {
      fmt::print("{:<17}{}={}  ({})  {}\n", "", spec.name, spec.default_value, describe_range(spec),
                 spec.description);
    }
  }
}

Row describe_dataset(const Dataset& d, const Location& location) {
  Row j;
  j["name"] = d.name;
  j["title"] = d.title;
  j["kind"] = name_of(d.kind);
  j["type"] = name_of(d.type);
  j["extent"] = {d.extent.x, d.extent.y, d.extent.z};
  j["time_steps"] = d.time_steps;
  j["labels"] = d.labels == 0 ? Row(nullptr) : Row(d.labels);
  j["licence"] = d.licence;
  j["citation"] = d.citation;
  j["origin"] = d.origin;
  j["file"] = d.file;
  j["generator"] = d.generator ? Row(d.generator->kind) : Row(nullptr);
  j["stand_in_for"] = d.stand_in_for;
  j["present"] = location.present;
  j["reason"] = location.missing;
  return j;
}

void list_datasets(const std::string& folder, const Environment& environment, bool json) {
  const Catalogue catalogue = Catalogue::from_folder(find_catalogue(folder, ""));
  const Places places{environment.data, environment.cache};
  Row all = Row::array();
  for (const Dataset& dataset : catalogue.all()) {
    Dataset small = dataset;  // where it is does not depend on how large its stand-in would be made
    small.scale = 1e-4;
    const Location location = locate(small, places);
    if (json) {
      all.push_back(describe_dataset(dataset, location));
      continue;
    }
    const std::string where = !location.present        ? "absent: " + location.missing
                              : !location.path.empty() ? "present"
                              : dataset.file.empty()
                                  ? "generated"
                                  : "absent, a generated stand-in takes its place";
    fmt::print("{:<26} {:<7} {:<3} {:>16}  {}\n{:<28}{}\n", dataset.name, name_of(dataset.kind),
               name_of(dataset.type),
               to_string(dataset.extent) +
                   (dataset.time_steps == 1 ? "" : fmt::format(" x{}", dataset.time_steps)),
               dataset.title, "", where);
  }
  if (json) print_json(all);
}

void list_metrics(bool json) {
  Row all = Row::array();
  for (const Metric& metric : all_metrics()) {
    all.push_back(
        {{"name", metric.name}, {"heading", metric.heading}, {"description", metric.description}});
    if (!json) fmt::print("{:<21} {:<17} {}\n", metric.name, metric.heading, metric.description);
  }
  if (json) print_json(all);
}

void list_access_modes(bool json) {
  Row all = Row::array();
  for (const gpu::CacheTraits& cache : gpu::all_caches()) {
    all.push_back({{"id", cache.id},
                   {"summary", cache.summary},
                   {"sized", cache.sized},
                   {"placeholders", cache.placeholders},
                   {"exact", cache.exact}});
    if (json) continue;
    fmt::print("{:<18} {}{}{}\n", cache.id, cache.summary, cache.sized ? ", of --cache-mib" : "",
               !cache.exact         ? ", images are not exact"
               : cache.placeholders ? ", first frames are not exact"
                                    : "");
  }
  if (json) print_json(all);
}

void list_stages(bool json) {
  Row all = Row::array();
  for (const StageTraits* stage : stage_traits()) {
    all.push_back({{"id", stage->id}, {"summary", stage->sentence}});
    if (!json) fmt::print("{:<18} {}\n", stage->id, stage->sentence);
  }
  if (json) print_json(all);
}

/// The keys of configurations and of the files that they name: a page of docs, or a JSON schema.
void list_config(bool json) {
  fmt::print("{}", json ? configuration_schema(vocabulary()) : configuration_page(vocabulary()));
}

/// The JSON schema of rows.
void list_rows() {
  std::vector<std::string> stages;
  for (const StageTraits* stage : stage_traits()) stages.emplace_back(stage->id);
  fmt::print("{}", row_schema(stages, render_schema()));
}

/// 3 where nothing can draw.
int list_devices(bool json) {
  Row all = Row::array();
  bool usable = false;
  for (const gpu::DeviceReport& d : gpu::list_devices()) {
    usable = usable || d.rejected.empty();
    all.push_back({{"index", d.index},
                   {"name", d.name},
                   {"type", d.type},
                   {"driver", d.driver},
                   {"api", d.api},
                   {"memory", d.memory},
                   {"largest_allocation", d.largest_allocation},
                   {"shared_memory", d.shared_memory},
                   {"subgroup", d.subgroup},
                   {"usable", d.rejected.empty()},
                   {"rejected", d.rejected}});
    if (json) continue;
    fmt::print("{}  {} ({}, {}, Vulkan {}), {} MiB, subgroups of {}\n", d.index, d.name, d.type,
               d.driver, d.api, d.memory >> 20, d.subgroup);
    for (const std::string& reason : d.rejected) fmt::print("   rejected: {}\n", reason);
  }
  if (json) print_json(all);
  if (!json && all.empty())
    fmt::print("no Vulkan device: no driver is installed, or none finds its hardware\n");
  return usable ? kExitOk : kExitEnvironment;
}

struct ListOptions {
  std::string what, datasets, data;
  bool json = false;
};

}  // namespace

Row describe_codecs() {
  Row all = Row::array();
  for (const codecs::Codec* codec : codecs::all_codecs()) all.push_back(describe_codec(*codec));
  return all;
}

void add_list_command(CLI::App& app, const Environment& environment, int& exit_code) {
  auto* command = app.add_subcommand("list",
                                     "Lists codecs, data sets, metrics, access modes, stages, "
                                     "devices, the keys of configurations or the fields of rows");
  auto options = std::make_shared<ListOptions>();
  options->data = environment.data;
  command
      ->add_option("what", options->what,
                   "codecs | datasets | metrics | access-modes | stages | devices | config | rows")
      ->required();
  command->add_option("--datasets", options->datasets, "folder of data set descriptions");
  command->add_option("--data", options->data, "folder that ${CVRBENCH_DATA} stands for");
  command->add_flag(
      "--json", options->json,
      "an array of objects on standard output; of config a JSON schema, as rows is always");
  command->callback([options, &environment, &exit_code] {
    Environment here = environment;
    here.data = options->data;
    exit_code = kExitOk;
    if (options->what == "codecs") return list_codecs(options->json);
    if (options->what == "datasets") return list_datasets(options->datasets, here, options->json);
    if (options->what == "metrics") return list_metrics(options->json);
    if (options->what == "access-modes" || options->what == "caches")  // its former name
      return list_access_modes(options->json);
    if (options->what == "stages") return list_stages(options->json);
    if (options->what == "config") return list_config(options->json);
    if (options->what == "rows") return list_rows();
    if (options->what == "devices") {
      exit_code = list_devices(options->json);
      return;
    }
    throw volumes::InputError(fmt::format(
        "list: expected codecs, datasets, metrics, access-modes, stages, devices, config "
        "or rows, found '{}'",
        options->what));
  });
}

}  // namespace cvr::experiments::cli
