#include "experiments/analysis/tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "experiments/analysis/curve_table.hpp"
#include "experiments/analysis/metrics.hpp"
#include "experiments/analysis/render_metrics.hpp"
#include "experiments/analysis/table_lines.hpp"
#include "experiments/analysis/table_notes.hpp"
#include "experiments/config/published.hpp"

namespace cvr::experiments {

namespace {

using Published = std::optional<PublishedTable>;

/// For each line, whether it is on the front of its data set, of the points that `point` reads.
std::vector<bool> find_front(const std::vector<TableLine>& lines,
                             std::optional<RatePoint> (*point)(const LineContext&)) {
  std::map<std::string, std::pair<std::vector<std::size_t>, std::vector<RatePoint>>> by_dataset;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (const auto found = point(context_of(lines[i], {}))) {
      auto& [indices, points] = by_dataset[lines[i].cell->dataset->name];
      indices.push_back(i);
      points.push_back(*found);
    }
  }
  std::vector<bool> on_front(lines.size());
  for (const auto& [dataset, found] : by_dataset) {
    const std::vector<bool> kept = pareto_front(found.second);
    for (std::size_t k = 0; k < kept.size(); ++k) on_front[found.first[k]] = kept[k];
  }
  return on_front;
}

TableColumn column_of(const Metric& metric, std::string heading) {
  return {std::string(metric.name), std::move(heading), std::string(unit_in(metric.heading)),
          std::string(metric.description), Align::kRight};
}

/// The number that a text begins with, of metrics whose cells hold several: "3; 0.25" is ordered by
/// 3.
std::optional<double> leading_number(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{}) return std::nullopt;
  const std::string_view rest = text.substr(static_cast<std::size_t>(end - text.data()));
  if (!rest.empty() && std::string_view(" ;/").find(rest.front()) == std::string_view::npos)
    return std::nullopt;
  return number;
}

/// What a metric reads of a line, and what is published beside it.
TableCell cell_of(const Metric& metric, const LineContext& context) {
  const Reading reading = metric.read(context);
  TableCell cell{reading.text, reading.number, reading.interval, {}};
  if (!cell.number && !metric.numeric) cell.number = leading_number(cell.text);
  if (const Metric* beside = published_beside(metric)) {
    const Reading stated = beside->read(context);
    if (!stated.text.empty()) cell.published = {stated.text, stated.number};
  }
  return cell;
}

void fill_columns(const TableSpec& spec, const std::vector<TableLine>& lines,
                  const Published& published, Table& table) {
  for (const std::string& name : spec.columns) {
    const Metric& metric = *find_metric(name);
    table.columns.push_back(column_of(metric, std::string(metric.heading)));
  }
  const std::vector<bool> on_front = find_front(lines, rate_point);
  const std::vector<bool> on_access_front = find_front(lines, access_point);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    LineContext context = context_of(lines[i], published);
    context.on_front = on_front[i];
    context.on_access_front = on_access_front[i];
    std::vector<std::string> labels;
    for (const std::string& key : spec.rows) labels.push_back(label_of(*lines[i].cell, key));
    table.add_line(std::move(labels));
    LineOfCells& line = table.lines.back();
    for (const std::string& name : spec.columns)
      line.cells.push_back(cell_of(*find_metric(name), context));
    line.fronts.emplace();
    if (context.on_front) line.fronts->emplace_back("pareto");
    if (context.on_access_front) line.fronts->emplace_back("access_front");
  }
}

/// All combinations of the labels' values that occur, the values in the order of their first
/// occurrence.
std::vector<std::vector<std::string>> combinations(const std::vector<TableLine>& lines,
                                                   const std::vector<std::string>& labels) {
  std::vector<std::map<std::string, std::size_t>> order(labels.size());
  std::map<std::vector<std::size_t>, std::vector<std::string>> sorted;
  for (const TableLine& line : lines) {
    std::vector<std::size_t> position;
    std::vector<std::string> values;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      values.push_back(label_of(*line.cell, labels[i]));
      position.push_back(order[i].emplace(values.back(), order[i].size()).first->second);
    }
    sorted.emplace(std::move(position), std::move(values));
  }
  std::vector<std::vector<std::string>> all;
  for (auto& [position, values] : sorted) all.push_back(std::move(values));
  return all;
}

std::size_t place_of(const std::vector<std::vector<std::string>>& all, const Cell& cell,
                     const std::vector<std::string>& keys) {
  std::vector<std::string> values;
  for (const std::string& key : keys) values.push_back(label_of(cell, key));
  return static_cast<std::size_t>(std::ranges::find(all, values) - all.begin());
}

/// "measured (published)"; several cells of one place are separated by slashes, and the first of
/// them gives the numbers.
void add_to_place(TableCell found, TableCell& place) {
  if (found.published)
    found.text += fmt::format("{}({})", found.text.empty() ? "" : " ", found.published->text);
  if (found.text.empty()) return;
  if (place.text.empty()) {
    place = std::move(found);
  } else {
    place.text += " / " + found.text;
  }
}

void fill_pivot(const TableSpec& spec, const std::vector<TableLine>& lines,
                const Published& published, Table& table) {
  const Metric& metric = *find_metric(spec.pivot->metric);
  const auto columns = combinations(lines, spec.pivot->columns);
  const auto labels = combinations(lines, spec.rows);
  for (const auto& column : columns)
    table.columns.push_back(column_of(metric, fmt::format("{}", fmt::join(column, " "))));
  for (const auto& label : labels) {
    table.add_line(label);
    table.lines.back().cells.resize(label.size() + columns.size());
  }
  for (const TableLine& line : lines) {
    LineOfCells& place = table.lines[place_of(labels, *line.cell, spec.rows)];
    const std::size_t column = place_of(columns, *line.cell, spec.pivot->columns);
    add_to_place(cell_of(metric, context_of(line, published)),
                 place.cells[spec.rows.size() + column]);
  }
}

}  // namespace

Table make_table(const TableSpec& spec, const Config& config, const std::vector<Result>& rows) {
  Table table;
  table.name = spec.name;
  table.title = spec.title;
  Published published;
  if (const auto& place = spec.published)
    published = load_published(place->file, place->table, place->scaled);
  const auto latest = latest_by(rows, &Result::key);
  const auto lines = collect_lines(Filter{spec.where}, spec.renders(), config, latest);
  for (const std::string& key : spec.rows) table.add_label(key);
  if (spec.pivot) {
    const bool beside = published && published_beside(*find_metric(spec.pivot->metric)) != nullptr;
    table.notes.push_back(explain_pivot(*spec.pivot, beside));
    fill_pivot(spec, lines, published, table);
  } else if (!spec.bd_reference.empty()) {
    table.notes.push_back(explain_curves(spec.bd_reference));
    fill_curves(spec, lines, table);
  } else {
    fill_columns(spec, lines, published, table);
    table.notes.push_back(explain_columns(table));
  }
  add_origin_notes(lines, table.notes);
  if (published) {
    table.published = {published->citation, published->title, published->hardware};
    add_published_note(*table.published, table.notes);
  }
  add_status_notes(lines, table.notes);
  return table;
}

}  // namespace cvr::experiments
