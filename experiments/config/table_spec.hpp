// A table of a configuration as it is asked for, and what claims are written with too: labels,
// conditions, metrics, published figures.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/config/cells.hpp"
#include "experiments/config/keys.hpp"
#include "experiments/config/metric_names.hpp"

namespace cvr::experiments {

/// A table of a file of published figures.
struct PublishedPlace {
  std::string file, table;
  std::vector<std::string> scaled;  ///< parameters of codecs that need not agree
};

/// Spreads one metric over columns.
struct Pivot {
  std::vector<std::string> columns;  ///< labels whose combinations become columns
  std::string metric;
};

struct TableSpec {
  std::string name, title;
  std::vector<std::string> rows;     ///< labels that tell a line from the others
  std::vector<std::string> columns;  ///< names of metrics
  Conditions where;
  std::optional<PublishedPlace> published;
  std::optional<Pivot> pivot;
  std::string bd_reference;  ///< labels of the curve that others are compared with; empty: none

  /// Whether it is about cells of the stage render.
  bool renders() const;
};

/// All labels of table lines, those of images and the parameters of all codecs among them.
std::vector<std::string> line_labels();

/// One of line_labels().
Shape<std::string> line_label();
/// The name of one of the metrics.
Shape<std::string> metric_name(MetricNames metrics);
/// A map of labels to globs or lists of globs, of which one must match.
Shape<Conditions> conditions();
std::vector<Key<PublishedPlace>> published_place_keys(const std::string& config_path);
std::vector<Key<Pivot>> pivot_keys(MetricNames metrics);
/// `config_path`: what the path of published figures is relative to.
std::vector<Key<TableSpec>> table_keys(const std::string& config_path, MetricNames metrics);

/// Throws InputError.
TableSpec read_table(const YamlValue& value, const std::string& config_path, MetricNames metrics);

}  // namespace cvr::experiments
