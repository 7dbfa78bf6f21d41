// Figures in documents are written from rows: a marker names what stands behind it.
//
//   <!--cvrbench {run: quick, value: rate, where: {dataset: aal, codec: csgv-ctx}}-->0.746<!--/cvrbench-->
//
//   <!--cvrbench
//   run: quick
//   rows: [codec]
//   columns: [rate, encode_mvoxel_per_s]
//   where: {dataset: aal}
//   -->
//   | codec | ...
//   <!--/cvrbench-->
//
// What a marker holds is YAML (config/marker_spec.hpp). Markers in code, fenced or in backticks, are left as
// they stand.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiments/config/config.hpp"
#include "experiments/config/marker_spec.hpp"
#include "experiments/results/rows.hpp"

namespace cvr::experiments {

/// A folder of results/evidence: a configuration as it was run, and its rows.
struct Evidence {
  std::string name;
  Config config;
  std::vector<Result> rows;
  std::string readme;  ///< the folder's own page: machine, command, what else is to be known
};

/// The evidence of a name. Throws InputError where there is none.
using EvidenceSource = std::function<const Evidence&(const std::string&)>;

/// The text with what stands between its markers written anew. Throws InputError, "FILE:LINE: ..." of
/// the marker, for one without an end, of what evidence does not have, or of several figures where
/// one is asked for.
std::string fill_markers(const std::string& path, const std::string& text,
                         const EvidenceSource& evidence, MetricNames metrics);

/// The page of a run: what its folder says of it, its figures (paths from the page), all its tables,
/// its claims and their groups with the ids of the rows.
std::string evidence_page(const Evidence& evidence, const std::vector<std::string>& figures = {});

}  // namespace cvr::experiments
