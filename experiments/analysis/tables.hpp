// Makes the tables of a configuration from rows.
#pragma once

#include <vector>

#include "experiments/analysis/table.hpp"
#include "experiments/config/config.hpp"
#include "experiments/results/rows.hpp"

namespace cvr::experiments {

/// The table of a configuration from rows; the last row of a cell counts. Cells that were not run
/// yet are named in a note. Throws InputError for a file of published figures that cannot be read.
Table make_table(const TableSpec& spec, const Config& config, const std::vector<Result>& rows);

}  // namespace cvr::experiments
