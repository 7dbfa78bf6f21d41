// Tables: lines of text cells made from rows, rendered as Markdown (aligned, so it reads on a
// terminal too), CSV or LaTeX.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/config/config.hpp"
#include "experiments/results/rows.hpp"

namespace cvr::experiments {

enum class TableFormat : std::uint8_t { kMarkdown, kCsv, kLatex };
/// "md", "csv", "latex".
std::optional<TableFormat> table_format_from_name(std::string_view name);

struct Table {
  std::string name, title;
  std::vector<std::string> headings;
  std::size_t labels = 0;  ///< leading columns that label a line: aligned to the left
  std::vector<std::vector<std::string>> lines;
  std::vector<std::string> notes;  ///< below the table: machine, stand-ins, statuses
};

/// The table of a configuration from rows; the last row of a cell counts. Cells that were not run
/// yet are named in a note.
Table make_table(const TableSpec& spec, const Config& config, const std::vector<Row>& rows);

std::string render(const Table& table, TableFormat format);

}  // namespace cvr::experiments
