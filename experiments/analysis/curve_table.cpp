#include "experiments/analysis/curve_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "experiments/analysis/rate_distortion.hpp"

namespace cvr::experiments {

namespace {

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
TableCell range_cell(const std::vector<RatePoint>& points, double RatePoint::*value, int digits) {
  if (points.empty()) return {};
  const auto [least, largest] = std::ranges::minmax(points, {}, value);
  const auto text = [&](double end) {
    return std::isfinite(end) ? fmt::format("{:.{}f}", end, digits) : std::string("exact");
  };
  const std::string range = least.*value == largest.*value
                                ? text(least.*value)
                                : fmt::format("{} .. {}", text(least.*value), text(largest.*value));
  return {range, least.*value, {}, {}};
}

void add_columns(Table& table) {
  const auto add = [&](const char* name, const char* heading, const char* description) {
    table.columns.push_back(
        {name, heading, std::string(unit_in(heading)), description, Align::kRight});
  };
  add("points", "points", "of the curve of PSNR over bits per voxel");
  add("bits_per_voxel", "bits/voxel", "least and largest of the curve");
  add("volume_psnr_db", "PSNR dB", "least and largest of the curve");
  add("bd_psnr_db", "BD-PSNR dB",
      "mean difference to the reference over the logarithm of the rates that both have "
      "(Bjontegaard, with monotone cubics)");
  add("common_bits_per_voxel", "over", "the bits per voxel that both have");
}

void add_note_once(Note note, std::vector<Note>& notes) {
  const auto same = [&](const Note& other) { return other.plain() == note.plain(); };
  if (std::ranges::none_of(notes, same)) notes.push_back(std::move(note));
}

/// The mean difference of a curve to the reference of its data set and the rates it is over; empty
/// cells and a note where there is none.
std::vector<TableCell> compare(const Curve& curve, const std::vector<Curve>& curves,
                               const std::string& reference_name, std::vector<Note>& notes) {
  const auto reference = std::ranges::find_if(curves, [&](const Curve& c) {
    return c.dataset == curve.dataset && c.name == reference_name;
  });
  if (reference == curves.end()) {
    add_note_once(Note().given(fmt::format("{} has no curve '{}' to compare with.", curve.dataset,
                                           reference_name)),
                  notes);
    return {{}, {}};
  }
  const auto found = bd_psnr(reference->points, curve.points);
  if (!found) {
    notes.push_back(
        Note().given(fmt::format("{} {}: {}.", curve.dataset, curve.name, found.error().message)));
    return {{}, {}};
  }
  return {{fmt::format("{:+.2f}", found->db), found->db, {}, {}},
          {fmt::format("{:.3f} .. {:.3f}", found->least_bits, found->largest_bits),
           found->least_bits,
           {},
           {}}};
}

}  // namespace

void fill_curves(const TableSpec& spec, const std::vector<TableLine>& lines, Table& table) {
  add_columns(table);
  const std::vector<Curve> curves = collect_curves(spec, lines);
  for (const Curve& curve : curves) {
    table.add_line(curve.labels);
    std::vector<TableCell>& cells = table.lines.back().cells;
    cells.push_back(
        {std::to_string(curve.points.size()), static_cast<double>(curve.points.size()), {}, {}});
    cells.push_back(range_cell(curve.points, &RatePoint::bits_per_voxel, 3));
    cells.push_back(range_cell(curve.points, &RatePoint::psnr_db, 2));
    for (TableCell& cell : compare(curve, curves, spec.bd_reference, table.notes))
      cells.push_back(std::move(cell));
  }
}

}  // namespace cvr::experiments
