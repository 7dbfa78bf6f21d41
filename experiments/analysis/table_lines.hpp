// The lines that tables and claims are about: the cells of a configuration that agree in all but
// the stage, and their rows.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/analysis/metrics.hpp"
#include "experiments/analysis/stage_rows.hpp"
#include "experiments/config/config.hpp"
#include "experiments/config/published.hpp"
#include "experiments/results/rows.hpp"

namespace cvr::experiments {

struct TableLine {
  const Cell* cell;  ///< any of the line
  StageRows rows;    ///< nullptr where there is none yet
};

/// The lines of the cells of the render stage or of those of all others that `where` keeps, data
/// set by data set, else in the order of the configuration. `latest`: rows by their key. Points
/// into both.
std::vector<TableLine> collect_lines(const Filter& where, bool renders, const Config& config,
                                     const std::map<std::string, Result>& latest);

/// What the metrics of a line are read from.
LineContext context_of(const TableLine& line, const std::optional<PublishedTable>& published);

}  // namespace cvr::experiments
