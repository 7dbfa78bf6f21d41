#include "experiments/analysis/table_formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/analysis/csv.hpp"
#include "experiments/analysis/escaping.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments {

namespace {

using Texts = std::vector<std::string>;

/// Headings, then the cells of each line.
std::vector<Texts> texts_of(const Table& table, std::string (*write)(const std::string&)) {
  std::vector<Texts> lines(1);
  for (const TableColumn& column : table.columns) lines[0].push_back(write(column.heading));
  for (const LineOfCells& line : table.lines) {
    Texts& texts = lines.emplace_back();
    for (const TableCell& cell : line.cells) texts.push_back(write(cell.text));
  }
  return lines;
}

std::string as_it_is(const std::string& text) { return text; }
std::string in_markdown(const std::string& text) { return escape_markdown(text); }
std::string in_latex(const std::string& text) { return escape_latex(text); }

/// A note in Markdown, which comments of LaTeX are written in too.
std::string marked(const Note& note) {
  std::string text;
  for (const NotePart& part : note.parts()) {
    switch (part.kind) {
      case NotePart::Kind::kTerm:
        text += "**" + escape_markdown(part.text, false) + "**";
        break;
      case NotePart::Kind::kOwn:
        text += part.text;
        break;
      case NotePart::Kind::kGiven:
        text += escape_markdown(part.text, false);
        break;
    }
  }
  return volumes::printable(text);
}

std::string render_markdown(const Table& table) {
  const std::vector<Texts> lines = texts_of(table, in_markdown);
  std::vector<std::size_t> widths(table.columns.size(), 3);
  for (const Texts& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  const auto is_left = [&](std::size_t c) { return table.columns[c].align == Align::kLeft; };
  std::string text = fmt::format("### {}\n\n", escape_markdown(table.title, false));
  for (const Texts& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) {
      text += is_left(c) ? fmt::format("| {:<{}} ", line[c], widths[c])
                         : fmt::format("| {:>{}} ", line[c], widths[c]);
    }
    text += "|\n";
    if (&line != &lines.front()) continue;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string dashes(widths[c] + 1, '-');
      text += is_left(c) ? fmt::format("|:{}", dashes) : fmt::format("|{}:", dashes);
    }
    text += "|\n";
  }
  if (!table.notes.empty()) text += "\n";
  for (const Note& note : table.notes) text += fmt::format("- {}\n", marked(note));
  return text;
}

std::string render_latex(const Table& table) {
  std::string columns;
  for (const TableColumn& column : table.columns)
    columns += column.align == Align::kLeft ? 'l' : 'r';
  std::string text = fmt::format("% {}\n\\begin{{tabular}}{{{}}}\n\\hline\n",
                                 volumes::printable(table.title), columns);
  const std::vector<Texts> lines = texts_of(table, in_latex);
  for (const Texts& line : lines) {
    std::string_view separator;
    for (const std::string& cell : line) {
      text.append(separator).append(cell);
      separator = " & ";
    }
    text += " \\\\\n";
    if (&line == &lines.front()) text += "\\hline\n";
  }
  text += "\\hline\n\\end{tabular}\n";
  for (const Note& note : table.notes) text += fmt::format("% {}\n", marked(note));
  return text;
}

Row describe(const TableColumn& column) {
  return {{"name", volumes::printable(column.name)},
          {"heading", volumes::printable(column.heading)},
          {"unit", column.unit},
          {"description", column.description},
          {"align", name_of(column.align)}};
}

void add_number(const std::optional<double>& number, Row& row) {
  if (number && std::isfinite(*number)) row["number"] = *number;
}

Row describe(const TableCell& cell) {
  Row row{{"text", volumes::printable(cell.text)}};
  add_number(cell.number, row);
  if (cell.interval && std::isfinite(cell.interval->low) && std::isfinite(cell.interval->high))
    row["interval"] = {cell.interval->low, cell.interval->high};
  if (cell.published) {
    row["published"] = {{"text", volumes::printable(cell.published->text)}};
    add_number(cell.published->number, row["published"]);
  }
  return row;
}

Row describe(const LineOfCells& line) {
  Row row{{"cells", Row::array()}};
  for (const TableCell& cell : line.cells) row["cells"].push_back(describe(cell));
  if (line.fronts) row["fronts"] = *line.fronts;
  return row;
}

}  // namespace

const std::vector<TableFormatTraits>& table_formats() {
  static const std::vector<TableFormatTraits> kFormats{{TableFormat::kMarkdown, "md", ".md"},
                                                       {TableFormat::kCsv, "csv", ".csv"},
                                                       {TableFormat::kLatex, "latex", ".tex"},
                                                       {TableFormat::kJson, "json", ".json"}};
  return kFormats;
}

std::optional<TableFormat> table_format_from_name(std::string_view name) {
  const auto found = std::ranges::find(table_formats(), name, &TableFormatTraits::name);
  if (found == table_formats().end()) return std::nullopt;
  return found->format;
}

Row to_row(const Table& table) {
  Row row;
  row["schema"] = 1;
  row["name"] = volumes::printable(table.name);
  row["title"] = volumes::printable(table.title);
  row["columns"] = Row::array();
  for (const TableColumn& column : table.columns) row["columns"].push_back(describe(column));
  row["labels"] = table.labels;
  row["lines"] = Row::array();
  for (const LineOfCells& line : table.lines) row["lines"].push_back(describe(line));
  row["notes"] = Row::array();
  for (const Note& note : table.notes) row["notes"].push_back(note.plain());
  if (table.published) {
    row["published"] = {{"citation", volumes::printable(table.published->citation)},
                        {"title", volumes::printable(table.published->title)},
                        {"hardware", volumes::printable(table.published->hardware)}};
  }
  return row;
}

std::string render(const Table& table, TableFormat format) {
  switch (format) {
    case TableFormat::kMarkdown:
      return render_markdown(table);
    case TableFormat::kCsv:
      return csv_text(texts_of(table, as_it_is));
    case TableFormat::kLatex:
      return render_latex(table);
    case TableFormat::kJson:
      return to_row(table).dump(1) + "\n";
  }
  return "";
}

}  // namespace cvr::experiments
