#include "experiments/analysis/tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "experiments/analysis/escaping.hpp"
#include "experiments/analysis/metrics.hpp"
#include "experiments/analysis/render_metrics.hpp"
#include "experiments/analysis/table_lines.hpp"
#include "experiments/config/published.hpp"
#include "experiments/results/provenance.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments {

namespace {

void add_status_notes(const std::vector<TableLine>& lines, std::vector<std::string>& notes) {
  std::map<std::string, std::vector<std::string>> reasons;
  std::size_t not_run = 0;
  for (const TableLine& line : lines) {
    for (const auto& [stage, row] : line.rows) {
      if (row == nullptr) {
        ++not_run;
        continue;
      }
      const std::string status = row->value("status", "");
      if (status == kOk) continue;
      const std::string reason = escape_markdown(
          fmt::format("{} {}: {}", stage, status, row->value("reason", "no reason given")), false);
      auto& who = reasons[reason];
      std::string name = status == kDataMissing ? line.cell->dataset->name : line.cell->codec;
      if (line.cell->render && status != kDataMissing) name += " " + line.cell->render->access;
      if (std::ranges::find(who, name) == who.end()) who.push_back(name);
    }
  }
  for (const auto& [reason, who] : reasons)
    notes.push_back(fmt::format("{} ({})", reason,
                                escape_markdown(fmt::format("{}", fmt::join(who, ", ")), false)));
  if (not_run > 0) notes.push_back(fmt::format("{} cells have not been run.", not_run));
}

void add_origin_notes(const std::vector<TableLine>& lines, std::vector<std::string>& notes) {
  std::vector<std::string> machines, labels, devices;
  bool software = false;
  const auto add_once = [](std::vector<std::string>& texts, const std::string& text) {
    if (!text.empty() && std::ranges::find(texts, text) == texts.end()) texts.push_back(text);
  };
  for (const TableLine& line : lines) {
    for (const auto& [stage, row] : line.rows) {
      if (row == nullptr) continue;
      if (row->contains("provenance")) add_once(machines, hardware_line((*row)["provenance"]));
      if (row->contains("device")) {
        const Row& device = (*row)["device"];
        add_once(devices, fmt::format("{} ({}, {})", device.value("name", "?"),
                                      device.value("type", "?"), device.value("driver", "?")));
        software = software || device.value("type", "") == "software";
      }
      if (!row->contains("dataset")) continue;
      const std::string label = (*row)["dataset"].value("label", "");
      if (!label.empty())
        add_once(labels, fmt::format("{} is a {} volume", line.cell->dataset->name, label));
    }
  }
  for (const std::string& machine : machines)
    notes.push_back("Measured on: " + escape_markdown(machine, false) + ".");
  for (const std::string& device : devices)
    notes.push_back("Drawn on: " + escape_markdown(device, false) + ".");
  if (software) {
    notes.push_back(
        "A software device draws on the processor: these are CPU times, not comparable with those "
        "of a GPU. "
        "What carries over "
        "are pictures, counts of work and memory.");
  }
  for (std::string label : labels) {
    if (const std::size_t at = label.find(" is a stand-in for "); at != std::string::npos) {
      label = label.substr(0, label.size() - std::string_view(" volume").size());
      label += " voxels: a generated volume, its rates are not those of the original";
    }
    notes.push_back(escape_markdown(label, false) + ".");
  }
}

/// What the columns mean, for who sees such a table for the first time.
std::string explain_columns(const TableSpec& spec) {
  std::string text = "Columns: ";
  if (!spec.bd_reference.empty()) {
    return fmt::format(
        "Columns: **points** of the curve of PSNR over bits a voxel; **bits/voxel** and **PSNR "
        "dB** their ranges; **BD-PSNR dB** mean "
        "difference to the curve of {} over the logarithm of the rates that both have "
        "(Bjontegaard, with monotone cubics); **over** "
        "those rates.",
        escape_markdown(spec.bd_reference, false));
  }
  if (spec.pivot) {
    const Metric* metric = find_metric(spec.pivot->metric);
    const std::string_view published = !spec.published || published_beside(*metric) == nullptr
                                           ? ""
                                           : ", and in parentheses what the publication states";
    return fmt::format("Cells: **{}** {}{}. Columns: {}.", metric->heading, metric->description,
                       published, fmt::join(spec.pivot->columns, ", "));
  }
  for (const std::string& column : spec.columns) {
    const Metric* metric = find_metric(column);
    text += fmt::format("{}**{}** {}", text.ends_with(": ") ? "" : "; ", metric->heading,
                        metric->description);
  }
  return text + ".";
}

std::vector<std::string> escaped_for_markdown(const std::vector<std::string>& cells) {
  std::vector<std::string> escaped;
  for (const std::string& cell : cells) escaped.push_back(escape_markdown(cell));
  return escaped;
}

std::string render_markdown(const Table& table) {
  const std::vector<std::string> headings = escaped_for_markdown(table.headings);
  std::vector<std::vector<std::string>> lines;
  for (const auto& line : table.lines) lines.push_back(escaped_for_markdown(line));
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < headings.size(); ++c) {
    std::size_t width = std::max<std::size_t>(3, headings[c].size());
    for (const auto& line : lines) width = std::max(width, line[c].size());
    widths.push_back(width);
  }
  std::string text = fmt::format("### {}\n\n", escape_markdown(table.title, false));
  const auto add_line = [&](const std::vector<std::string>& cells) {
    for (std::size_t c = 0; c < cells.size(); ++c) {
      text += c < table.labels ? fmt::format("| {:<{}} ", cells[c], widths[c])
                               : fmt::format("| {:>{}} ", cells[c], widths[c]);
    }
    text += "|\n";
  };
  add_line(headings);
  for (std::size_t c = 0; c < widths.size(); ++c) {
    const std::string dashes(widths[c] + 1, '-');
    text += c < table.labels ? fmt::format("|:{}", dashes) : fmt::format("|{}:", dashes);
  }
  text += "|\n";
  for (const auto& line : lines) add_line(line);
  if (!table.notes.empty()) text += "\n";
  for (const std::string& note : table.notes)
    text += fmt::format("- {}\n", volumes::printable(note));
  return text;
}

std::string render_csv(const Table& table) {
  std::string text;
  const auto add_line = [&text](const std::vector<std::string>& cells) {
    for (std::size_t c = 0; c < cells.size(); ++c)
      text.append(c == 0 ? "" : ",").append(escape_csv(cells[c]));
    text += "\n";
  };
  add_line(table.headings);
  for (const auto& line : table.lines) add_line(line);
  return text;
}

std::string render_latex(const Table& table) {
  std::string columns(table.labels, 'l');
  columns.append(table.headings.size() - table.labels, 'r');
  std::string text = fmt::format("% {}\n\\begin{{tabular}}{{{}}}\n\\hline\n",
                                 volumes::printable(table.title), columns);
  const auto add_line = [&text](const std::vector<std::string>& cells) {
    for (std::size_t c = 0; c < cells.size(); ++c)
      text.append(c == 0 ? "" : " & ").append(escape_latex(cells[c]));
    text += " \\\\\n";
  };
  add_line(table.headings);
  text += "\\hline\n";
  for (const auto& line : table.lines) add_line(line);
  text += "\\hline\n\\end{tabular}\n";
  for (const std::string& note : table.notes)
    text += fmt::format("% {}\n", volumes::printable(note));
  return text;
}

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

void fill_columns(const TableSpec& spec, const std::vector<TableLine>& lines,
                  const Published& published, Table& table) {
  for (const std::string& column : spec.columns)
    table.headings.emplace_back(find_metric(column)->heading);
  const std::vector<bool> on_front = find_front(lines, rate_point);
  const std::vector<bool> on_access_front = find_front(lines, access_point);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const TableLine& line = lines[i];
    LineContext context = context_of(line, published);
    context.on_front = on_front[i];
    context.on_access_front = on_access_front[i];
    std::vector<std::string> cells;
    for (const std::string& key : spec.rows) cells.push_back(label_of(*line.cell, key));
    for (const std::string& column : spec.columns)
      cells.push_back(find_metric(column)->read(context).text);
    table.lines.push_back(std::move(cells));
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

/// "measured (published)"; several cells of one place are separated by slashes.
void fill_pivot(const TableSpec& spec, const std::vector<TableLine>& lines,
                const Published& published, Table& table) {
  const Metric& metric = *find_metric(spec.pivot->metric);
  const Metric* beside = published_beside(metric);
  const auto columns = combinations(lines, spec.pivot->columns);
  const auto labels = combinations(lines, spec.rows);
  for (const auto& column : columns)
    table.headings.push_back(fmt::format("{}", fmt::join(column, " ")));
  for (const auto& label : labels) {
    table.lines.push_back(label);
    table.lines.back().resize(label.size() + columns.size());
  }
  const auto place_of = [](const auto& all, const Cell& cell,
                           const std::vector<std::string>& keys) {
    std::vector<std::string> values;
    for (const std::string& key : keys) values.push_back(label_of(cell, key));
    return static_cast<std::size_t>(std::ranges::find(all, values) - all.begin());
  };
  for (const TableLine& line : lines) {
    const LineContext context = context_of(line, published);
    std::string& cell =
        table.lines[place_of(labels, *line.cell, spec.rows)]
                   [spec.rows.size() + place_of(columns, *line.cell, spec.pivot->columns)];
    std::string text = metric.read(context).text;
    if (const std::string stated = beside == nullptr ? "" : beside->read(context).text;
        !stated.empty())
      text += fmt::format("{}({})", text.empty() ? "" : " ", stated);
    if (!text.empty()) cell += (cell.empty() ? "" : " / ") + text;
  }
}

/// The lines that agree in the labels of a table.
struct Curve {
  std::vector<std::string> labels;
  std::string dataset, name;  ///< name: the labels but the data set
  std::vector<RatePoint> points;
};

std::vector<Curve> collect_curves(const TableSpec& spec, const std::vector<TableLine>& lines) {
  std::vector<Curve> curves;
  for (const TableLine& line : lines) {
    if (line.cell->codec == kMemcpy) continue;
    Curve curve;
    std::vector<std::string> names;
    for (const std::string& key : spec.rows) {
      curve.labels.push_back(label_of(*line.cell, key));
      if (key != "dataset" && !curve.labels.back().empty()) names.push_back(curve.labels.back());
    }
    curve.dataset = line.cell->dataset->name;
    curve.name = fmt::format("{}", fmt::join(names, " "));
    auto at = std::ranges::find_if(
        curves, [&](const Curve& c) { return c.dataset == curve.dataset && c.name == curve.name; });
    if (at == curves.end()) at = curves.insert(curves.end(), std::move(curve));
    if (const auto point = rate_point(context_of(line, {}))) at->points.push_back(*point);
  }
  return curves;
}

/// Least and largest; an infinite PSNR is that of an exact volume.
std::string range_text(const std::vector<RatePoint>& points, double RatePoint::*value, int digits) {
  if (points.empty()) return "";
  const auto [least, largest] = std::ranges::minmax(points, {}, value);
  const auto text = [&](double end) {
    return std::isfinite(end) ? fmt::format("{:.{}f}", end, digits) : std::string("exact");
  };
  return least.*value == largest.*value
             ? text(least.*value)
             : fmt::format("{} .. {}", text(least.*value), text(largest.*value));
}

void fill_curves(const TableSpec& spec, const std::vector<TableLine>& lines, Table& table) {
  for (const char* heading : {"points", "bits/voxel", "PSNR dB", "BD-PSNR dB", "over"})
    table.headings.emplace_back(heading);
  const std::vector<Curve> curves = collect_curves(spec, lines);
  for (const Curve& curve : curves) {
    std::vector<std::string> cells = curve.labels;
    cells.push_back(std::to_string(curve.points.size()));
    cells.push_back(range_text(curve.points, &RatePoint::bits_per_voxel, 3));
    cells.push_back(range_text(curve.points, &RatePoint::psnr_db, 2));
    const auto reference = std::ranges::find_if(curves, [&](const Curve& c) {
      return c.dataset == curve.dataset && c.name == spec.bd_reference;
    });
    if (reference == curves.end()) {
      cells.insert(cells.end(), {"", ""});
      const std::string note = escape_markdown(
          fmt::format("{} has no curve '{}' to compare with.", curve.dataset, spec.bd_reference),
          false);
      if (std::ranges::find(table.notes, note) == table.notes.end()) table.notes.push_back(note);
    } else if (const auto found = bd_psnr(reference->points, curve.points)) {
      cells.push_back(fmt::format("{:+.2f}", found->db));
      cells.push_back(fmt::format("{:.3f} .. {:.3f}", found->least_bits, found->largest_bits));
    } else {
      cells.insert(cells.end(), {"", ""});
      table.notes.push_back(escape_markdown(
          fmt::format("{} {}: {}.", curve.dataset, curve.name, found.error().message), false));
    }
    table.lines.push_back(std::move(cells));
  }
}

}  // namespace

std::optional<TableFormat> table_format_from_name(std::string_view name) {
  if (name == "md") return TableFormat::kMarkdown;
  if (name == "csv") return TableFormat::kCsv;
  if (name == "latex") return TableFormat::kLatex;
  return std::nullopt;
}

Table make_table(const TableSpec& spec, const Config& config, const std::vector<Row>& rows) {
  Table table{spec.name, spec.title, {}, spec.rows.size(), {}, {}};
  std::optional<PublishedTable> published;
  if (spec.published) published = load_published(spec.published->file, spec.published->table);
  const auto latest = latest_by(rows, "key");
  const auto lines = collect_lines(Filter{spec.where}, spec.renders(), config, latest);
  for (const std::string& key : spec.rows) table.headings.push_back(key);
  table.notes.push_back(explain_columns(spec));
  if (spec.pivot) {
    fill_pivot(spec, lines, published, table);
  } else if (!spec.bd_reference.empty()) {
    fill_curves(spec, lines, table);
  } else {
    fill_columns(spec, lines, published, table);
  }
  add_origin_notes(lines, table.notes);
  if (published) {
    table.notes.push_back(
        fmt::format("Published: {}; {}.{}", escape_markdown(published->citation, false),
                    escape_markdown(published->title, false),
                    published->hardware.empty()
                        ? ""
                        : " Times there: " + escape_markdown(published->hardware, false) + "."));
  }
  add_status_notes(lines, table.notes);
  return table;
}

std::string render(const Table& table, TableFormat format) {
  switch (format) {
    case TableFormat::kMarkdown:
      return render_markdown(table);
    case TableFormat::kCsv:
      return render_csv(table);
    case TableFormat::kLatex:
      return render_latex(table);
  }
  return "";
}

}  // namespace cvr::experiments
