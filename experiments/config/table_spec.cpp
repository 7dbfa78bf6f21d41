#include "experiments/config/table_spec.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "codecs/registry.hpp"
#include "experiments/config/project_folders.hpp"
#include "experiments/config/render_options.hpp"

namespace cvr::experiments {

namespace fs = std::filesystem;

std::vector<std::string> line_labels() {
  std::vector<std::string> labels{"dataset", "extent",     "type",   "kind",
                                  "codec",   "parameters", "threads"};
  for (std::string& label : render_labels()) labels.push_back(std::move(label));
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    for (const auto& spec : codec->parameters()) {
      if (std::ranges::find(labels, spec.name) == labels.end()) labels.emplace_back(spec.name);
    }
  }
  return labels;
}

Shape<std::string> line_label() {
  return {[](const YamlValue& value) {
            const std::vector<std::string> labels = line_labels();
            std::string label(current_name(value.text("a label")));
            if (std::ranges::find(labels, label) == labels.end()) {
              value.expected(
                  fmt::format("one of {}{}", fmt::join(labels, ", "), did_you_mean(label, labels)));
            }
            return label;
          },
          "a label", std::string(kTextSchema)};
}

Shape<std::string> metric_name(MetricNames metrics) {
  return {[metrics](const YamlValue& value) {
            const std::string name = value.text();
            const MetricName* found = find_metric_name(metrics, name);
            if (found == nullptr)
              value.expected("a metric ('list metrics' names them)" +
                             did_you_mean(name, names_of(metrics)));
            return std::string(found->name);
          },
          "a metric", std::string(kTextSchema)};
}

Shape<Conditions> conditions() {
  const auto globs = one_or_list(one_text("a glob"), "globs");
  const std::string schema =
      fmt::format(R"({{"type": "object", "additionalProperties": {}}})", globs.schema);
  return {[label = line_label().read, read = globs.read](const YamlValue& value) {
            Conditions all;
            for (const auto& [key, values] : value.entries()) {
              const std::string name = label(key);
              for (const std::string& glob : read(values)) all.emplace_back(name, glob);
            }
            return all;
          },
          "a map of labels and globs, or lists of globs of which one must match", schema};
}

namespace {

/// Where a file of published figures may lie.
std::vector<fs::path> published_places(const std::string& config_path, const std::string& text) {
  if (text.ends_with(".yaml"))
    return {(fs::path(config_path).parent_path() / text).lexically_normal()};
  std::vector<fs::path> places = project_folders();
  for (fs::path& place : places)
    place = (place / "results" / "published" / (text + ".yaml")).lexically_normal();
  return places;
}

std::vector<std::string> texts_of(const std::vector<fs::path>& paths) {
  std::vector<std::string> texts;
  for (const fs::path& path : paths) texts.push_back(path.string());
  return texts;
}

}  // namespace

std::vector<Key<PublishedPlace>> published_place_keys(const std::string& config_path) {
  const Shape<std::string> file{
      [config_path](const YamlValue& value) {
        const auto places = published_places(config_path, value.text("a name or a path"));
        const auto found = std::ranges::find_if(
            places, [](const fs::path& place) { return fs::is_regular_file(place); });
        if (found == places.end())
          value.expected(fmt::format("a file at {}", fmt::join(texts_of(places), " or ")));
        return found->string();
      },
      "a name or a path", std::string(kTextSchema)};
  return {required(key("file", &PublishedPlace::file, file, "",
                       "Figures of a publication: NAME of results/published/NAME.yaml, or the path "
                       "of such a file (.yaml) from this one.")),
          required(key("table", &PublishedPlace::table, one_text("a name"), "",
                       "Name of a table in it.")),
          key("scaled", &PublishedPlace::scaled, list_of(one_text("a parameter"), "parameters"), "",
              "Parameters of codecs that the cells have scaled with their volume, for instance "
              "brick: figures stand beside them whatever value they name.")};
}

std::vector<Key<Pivot>> pivot_keys(MetricNames metrics) {
  return {required(key("columns", &Pivot::columns, list_of(line_label(), "labels"), "",
                       "One column for each combination of these labels.")),
          required(key("metric", &Pivot::metric, metric_name(metrics), "",
                       "What stands in each cell, as \"measured (published)\"."))};
}

std::vector<Key<TableSpec>> table_keys(const std::string& config_path, MetricNames metrics) {
  using T = TableSpec;
  return {
      required(key("name", &T::name, one_text("a name"), "", "Also that of the table's files.")),
      required(key("title", &T::title, one_text("a title"), "", "Stands above the table.")),
      required(key("rows", &T::rows, list_of(line_label(), "labels of a line"), "",
                   "What labels a line: dataset, extent, type, kind, codec, parameters, threads, "
                   "an option of the stage render or a parameter of a codec. A table that names "
                   "such an option, here or under `where`, is about cells of the stage render, any "
                   "other about the rest.")),
      key("columns", &T::columns, list_of(metric_name(metrics), "metrics"), "",
          "Metrics (`cvrbench list metrics`)."),
      key("bd_psnr", &T::bd_reference, one_text("the labels of a curve"), "",
          "In place of `columns`: lines that agree in `rows` are a curve of PSNR over bits per "
          "voxel, and each curve is compared with the one whose labels but the data set are "
          "these."),
      key("pivot", &T::pivot, map_of(pivot_keys(metrics), "a map"), "",
          "In place of `columns`: spreads one metric over columns."),
      key("where", &T::where, conditions(), "", "Keeps cells whose labels match."),
      key("published", &T::published, map_of(published_place_keys(config_path), "a map"), "",
          "Figures of a publication, to stand beside the measured ones."),
  };
}

TableSpec read_table(const YamlValue& value, const std::string& config_path, MetricNames metrics) {
  TableSpec table;
  read_keys(value, table_keys(config_path, metrics), table);
  if (const int kinds = (table.columns.empty() ? 0 : 1) + (table.pivot ? 1 : 0) +
                        (table.bd_reference.empty() ? 0 : 1);
      kinds != 1)
    value.reject(fmt::format("expected one of the keys columns, pivot and bd_psnr, found {}",
                             kinds == 0 ? "none" : "several"));
  for (const std::string& column : table.columns) {
    if (!table.published && find_metric_name(metrics, column)->of_publication)
      value.reject(fmt::format(
          "expected the key published, for the column {} is of a publication, found none", column));
  }
  constexpr std::size_t kLongestName = 100;  // of a file, with its ending
  if (table.name.empty() || table.name.starts_with('.') || table.name.size() > kLongestName ||
      table.name.find('/') != std::string::npos) {
    value.reject(
        fmt::format("expected a table name of 1..{} bytes that names a file, without '/' and a '.' "
                    "in front, found '{}'",
                    kLongestName, table.name));
  }
  return table;
}

bool TableSpec::renders() const {
  return std::ranges::any_of(rows, is_render_label) ||
         (pivot && std::ranges::any_of(pivot->columns, is_render_label)) ||
         std::ranges::any_of(
             where, [&](const auto& condition) { return is_render_label(condition.first); });
}

}  // namespace cvr::experiments
