// Reads the tables of a configuration, and what its claims are written with too.
#pragma once

#include <string>
#include <string_view>

#include "experiments/config/config.hpp"
#include "experiments/config/metric_names.hpp"
#include "experiments/config/yaml_reader.hpp"

namespace cvr::experiments {

/// All labels of table lines, those of pictures and the parameters of all codecs among them.
std::vector<std::string> line_labels();
/// One of the labels of table lines; a parameter of any codec is one. Throws InputError.
std::string read_line_label(const YamlValue& value);
/// The name of a metric. Throws InputError.
std::string read_metric(const YamlValue& value, MetricNames metrics);
/// A map of labels to globs or lists of globs, of which one must match. Throws InputError.
Conditions read_conditions(const YamlValue& value);
/// {file: PATH beside the configuration, table: NAME}. Throws InputError.
PublishedPlace read_published_place(const YamlValue& value, const std::string& config_path);

/// Whether only cells of the render stage have it.
bool is_render_label(std::string_view name);

/// `config_path`: what the path of published figures is relative to. Throws InputError.
TableSpec read_table(const YamlValue& value, const std::string& config_path, MetricNames metrics);

}  // namespace cvr::experiments
