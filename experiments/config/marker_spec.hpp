// What a marker of a document asks for (analysis/markers.hpp): a figure, a table or verdicts of a run
// of results/evidence. docs/config.md lists the keys.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/config/table_spec.hpp"

namespace cvr::experiments {

struct MarkerSpec {
  std::string run;
  std::string value, least, largest, range, sum;  ///< a metric
  std::string cells;                              ///< a status
  std::string table, claim;                       ///< a name
  std::vector<std::string> claims;
  Conditions where, over;
  std::optional<std::uint64_t> decimals;
  TableSpec lines;  ///< a table of the marker's own
};

/// `document`: what the path of published figures is relative to.
std::vector<Key<MarkerSpec>> marker_keys(const std::string& document, MetricNames metrics);

/// `body`: its YAML; `place` names it in errors. Throws InputError.
MarkerSpec read_marker(const std::string& body, const std::string& place,
                       const std::string& document, MetricNames metrics);

}  // namespace cvr::experiments
