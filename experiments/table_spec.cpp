#include "experiments/table_spec.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "codecs/registry.hpp"
#include "experiments/metrics.hpp"

namespace cvr::experiments {

namespace {

std::string read_line_label(const YamlValue& value) {
  std::vector<std::string> labels{"dataset", "extent", "type", "codec", "parameters", "threads"};
  for (const std::string_view label : kRenderLabels) labels.emplace_back(label);
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    for (const auto& spec : codec->parameters()) {
      if (std::ranges::find(labels, spec.name) == labels.end()) labels.emplace_back(spec.name);
    }
  }
  const std::string label = value.text("a label");
  if (std::ranges::find(labels, label) == labels.end()) {
    value.expected(fmt::format("one of {}{}", fmt::join(labels, ", "), did_you_mean(label, labels)));
  }
  return label;
}

std::string read_metric(const YamlValue& value) {
  if (find_metric(value.text()) == nullptr)
    value.expected("a metric ('list metrics' names them)" + did_you_mean(value.text(), metric_names()));
  return value.text();
}

Pivot read_pivot(const YamlValue& value) {
  Pivot pivot;
  value.fields({{"columns",
                 [&](const YamlValue& v) {
                   for (const YamlValue& one : v.list("labels"))
                     pivot.columns.push_back(read_line_label(one));
                 },
                 true},
                {"metric", [&](const YamlValue& v) { pivot.metric = read_metric(v); }, true}});
  return pivot;
}

}  // namespace

TableSpec read_table(const YamlValue& value, const std::string& config_path) {
  TableSpec table;
  value.fields(
      {{"name", [&](const YamlValue& v) { table.name = v.text("a name"); }, true},
       {"title", [&](const YamlValue& v) { table.title = v.text("a title"); }, true},
       {"rows",
        [&](const YamlValue& v) {
          for (const YamlValue& one : v.list("labels of a line")) table.rows.push_back(read_line_label(one));
        },
        true},
       {"columns",
        [&](const YamlValue& v) {
          for (const YamlValue& one : v.list("metrics")) table.columns.push_back(read_metric(one));
        }},
       {"bd_psnr", [&](const YamlValue& v) { table.bd_reference = v.text("the labels of a curve"); }},
       {"pivot", [&](const YamlValue& v) { table.pivot = read_pivot(v); }},
       {"where",
        [&](const YamlValue& v) {
          for (const auto& [key, glob] : v.entries())
            table.where.emplace_back(key.text(), glob.text("a glob"));
        }},
       {"published", [&](const YamlValue& v) {
          v.fields({{"file",
                     [&](const YamlValue& f) {
                       const auto beside =
                           std::filesystem::path(config_path).parent_path() / f.text("a path");
                       table.published_file = beside.lexically_normal().string();
                       if (!std::filesystem::exists(table.published_file))
                         f.expected("a file at " + table.published_file);
                     },
                     true},
                    {"table", [&](const YamlValue& f) { table.published_table = f.text("a name"); }, true}});
        }}});
  if (const int kinds = (table.columns.empty() ? 0 : 1) + (table.pivot ? 1 : 0) + (table.bd_reference.empty() ? 0 : 1); kinds != 1)
    value.reject(fmt::format("expected one of the keys columns, pivot and bd_psnr, found {}", kinds == 0 ? "none" : "several"));
  if (table.name.find('/') != std::string::npos)
    value.reject("expected a table name without '/', found " + table.name);
  return table;
}

bool TableSpec::renders() const {
  const auto is_render_label = [](const std::string& name) {
    return std::ranges::find(kRenderLabels, name) != kRenderLabels.end();
  };
  return std::ranges::any_of(rows, is_render_label) ||
         (pivot && std::ranges::any_of(pivot->columns, is_render_label)) ||
         std::ranges::any_of(where, [&](const auto& condition) { return is_render_label(condition.first); });
}

}  // namespace cvr::experiments
