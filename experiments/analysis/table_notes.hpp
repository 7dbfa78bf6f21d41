// What stands below a table: what its columns mean, what it was measured on, and which cells have
// no result.
#pragma once

#include <vector>

#include "experiments/analysis/table.hpp"
#include "experiments/analysis/table_lines.hpp"
#include "experiments/config/config.hpp"

namespace cvr::experiments {

/// What the columns of metrics mean.
Note explain_columns(const Table& table);
/// What the cells of a table of one metric are; `published`: whether figures stand beside them.
Note explain_pivot(const Pivot& pivot, bool published);
/// What the columns of a table of curves mean.
Note explain_curves(const std::string& reference);

/// Machines, devices, and which volumes are not the originals.
void add_origin_notes(const std::vector<TableLine>& lines, std::vector<Note>& notes);
void add_published_note(const PublishedOrigin& published, std::vector<Note>& notes);
/// Which cells failed or were not run, and why.
void add_status_notes(const std::vector<TableLine>& lines, std::vector<Note>& notes);

}  // namespace cvr::experiments
