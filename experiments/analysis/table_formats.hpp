// A table in each of its formats, one writer a format.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/analysis/table.hpp"
#include "experiments/results/rows.hpp"

namespace cvr::experiments {

enum class TableFormat : std::uint8_t { kMarkdown, kCsv, kLatex, kJson };

struct TableFormatTraits {
  TableFormat format;
  std::string_view name;    ///< of an argument
  std::string_view ending;  ///< of a file, with its dot
};

/// All formats: "md", "csv", "latex" (.tex), "json".
const std::vector<TableFormatTraits>& table_formats();
std::optional<TableFormat> table_format_from_name(std::string_view name);

/// Markdown is aligned, so it reads on a terminal too. CSV holds the cells alone; LaTeX has the
/// notes as comments. JSON is an object of results/schema/table.schema.json.
std::string render(const Table& table, TableFormat format);

/// The object that the JSON is the text of. Its texts are shown as they stand: control characters
/// are made visible, and nothing else in them is escaped. Numbers that are infinite are left out.
Row to_row(const Table& table);

}  // namespace cvr::experiments
