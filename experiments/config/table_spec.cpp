#include "experiments/config/table_spec.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "codecs/registry.hpp"

namespace cvr::experiments {

std::vector<std::string> line_labels() {
  std::vector<std::string> labels{"dataset", "extent",     "type",   "kind",
                                  "codec",   "parameters", "threads"};
  for (const std::string_view label : kRenderLabels) labels.emplace_back(label);
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    for (const auto& spec : codec->parameters()) {
      if (std::ranges::find(labels, spec.name) == labels.end()) labels.emplace_back(spec.name);
    }
  }
  return labels;
}

std::string read_line_label(const YamlValue& value) {
  const std::vector<std::string> labels = line_labels();
  const std::string label = value.text("a label");
  if (std::ranges::find(labels, label) == labels.end()) {
    value.expected(
        fmt::format("one of {}{}", fmt::join(labels, ", "), did_you_mean(label, labels)));
  }
  return label;
}

std::string read_metric(const YamlValue& value, MetricNames metrics) {
  if (find_metric_name(metrics, value.text()) == nullptr)
    value.expected("a metric ('list metrics' names them)" +
                   did_you_mean(value.text(), names_of(metrics)));
  return value.text();
}

Conditions read_conditions(const YamlValue& value) {
  Conditions conditions;
  for (const auto& [key, globs] : value.entries()) {
    const std::string label = read_line_label(key);
    for (const YamlValue& glob : globs.list_or_one("globs"))
      conditions.emplace_back(label, glob.text("a glob"));
  }
  return conditions;
}

PublishedPlace read_published_place(const YamlValue& value, const std::string& config_path) {
  PublishedPlace place;
  value.fields({{"file",
                 [&](const YamlValue& f) {
                   const auto beside =
                       std::filesystem::path(config_path).parent_path() / f.text("a path");
                   place.file = beside.lexically_normal().string();
                   if (!std::filesystem::is_regular_file(place.file))
                     f.expected("a file at " + place.file);
                 },
                 true},
                {"table", [&](const YamlValue& f) { place.table = f.text("a name"); }, true}});
  return place;
}

bool is_render_label(std::string_view name) {
  return std::ranges::find(kRenderLabels, name) != kRenderLabels.end();
}

namespace {

Pivot read_pivot(const YamlValue& value, MetricNames metrics) {
  Pivot pivot;
  value.fields(
      {{"columns",
        [&](const YamlValue& v) {
          for (const YamlValue& one : v.list("labels"))
            pivot.columns.push_back(read_line_label(one));
        },
        true},
       {"metric", [&](const YamlValue& v) { pivot.metric = read_metric(v, metrics); }, true}});
  return pivot;
}

}  // namespace

TableSpec read_table(const YamlValue& value, const std::string& config_path, MetricNames metrics) {
  TableSpec table;
  value.fields({{"name", [&](const YamlValue& v) { table.name = v.text("a name"); }, true},
                {"title", [&](const YamlValue& v) { table.title = v.text("a title"); }, true},
                {"rows",
                 [&](const YamlValue& v) {
                   for (const YamlValue& one : v.list("labels of a line"))
                     table.rows.push_back(read_line_label(one));
                 },
                 true},
                {"columns",
                 [&](const YamlValue& v) {
                   for (const YamlValue& one : v.list("metrics"))
                     table.columns.push_back(read_metric(one, metrics));
                 }},
                {"bd_psnr",
                 [&](const YamlValue& v) { table.bd_reference = v.text("the labels of a curve"); }},
                {"pivot", [&](const YamlValue& v) { table.pivot = read_pivot(v, metrics); }},
                {"where", [&](const YamlValue& v) { table.where = read_conditions(v); }},
                {"published", [&](const YamlValue& v) {
                   table.published = read_published_place(v, config_path);
                 }}});
  if (const int kinds = (table.columns.empty() ? 0 : 1) + (table.pivot ? 1 : 0) +
                        (table.bd_reference.empty() ? 0 : 1);
      kinds != 1)
    value.reject(fmt::format("expected one of the keys columns, pivot and bd_psnr, found {}",
                             kinds == 0 ? "none" : "several"));
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
