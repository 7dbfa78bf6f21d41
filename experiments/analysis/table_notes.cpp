#include "experiments/analysis/table_notes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "experiments/results/provenance.hpp"

namespace cvr::experiments {

namespace {

void add_once(std::vector<std::string>& texts, const std::string& text) {
  if (!text.empty() && std::ranges::find(texts, text) == texts.end()) texts.push_back(text);
}

/// What the rows of a table tell of where they come from.
struct Origins {
  std::vector<std::string> machines, devices, labels;
  bool software = false;

  void add(const TableLine& line, const Result& row) {
    if (!row.provenance.machine.empty()) add_once(machines, hardware_line(row.provenance));
    if (row.device) {
      add_once(devices,
               fmt::format("{} ({}, {})", row.device->name, row.device->type, row.device->driver));
      software = software || row.device->type == "software";
    }
    if (!row.dataset.label.empty())
      add_once(labels,
               fmt::format("{} is a {} volume", line.cell->dataset->name, row.dataset.label));
  }
};

/// The line's cell as a note on statuses names it.
std::string name_in_status(const TableLine& line, bool data_missing) {
  if (data_missing) return line.cell->dataset->name;
  return line.cell->codec + (line.cell->render ? " " + line.cell->render->access : "");
}

}  // namespace

Note explain_columns(const Table& table) {
  Note note;
  note.own("Columns: ");
  for (std::size_t c = table.labels; c < table.columns.size(); ++c) {
    const TableColumn& column = table.columns[c];
    if (c > table.labels) note.own("; ");
    note.term(column.heading).own(" " + column.description);
  }
  return note.own(".");
}

Note explain_pivot(const Pivot& pivot, bool published) {
  const Metric* metric = find_metric(pivot.metric);
  return Note()
      .own("Cells: ")
      .term(std::string(metric->heading))
      .own(fmt::format(" {}{}. Columns: {}.", metric->description,
                       published ? ", and in parentheses what the publication states" : "",
                       fmt::join(pivot.columns, ", ")));
}

Note explain_curves(const std::string& reference) {
  return Note()
      .own("Columns: ")
      .term("points")
      .own(" of the curve of PSNR over bits per voxel; ")
      .term("bits/voxel")
      .own(" and ")
      .term("PSNR dB")
      .own(" their ranges; ")
      .term("BD-PSNR dB")
      .own(" mean difference to the curve of ")
      .given(reference)
      .own(" over the logarithm of the rates that both have (Bjontegaard, with monotone cubics); ")
      .term("over")
      .own(" those rates.");
}

void add_origin_notes(const std::vector<TableLine>& lines, std::vector<Note>& notes) {
  Origins origins;
  for (const TableLine& line : lines) {
    for (const auto& [stage, row] : line.rows) {
      if (row != nullptr) origins.add(line, *row);
    }
  }
  for (const std::string& machine : origins.machines)
    notes.push_back(Note().own("Measured on: ").given(machine).own("."));
  for (const std::string& device : origins.devices)
    notes.push_back(Note().own("Drawn on: ").given(device).own("."));
  if (origins.software) {
    notes.push_back(Note().own(
        "A software device draws on the processor: these are CPU times, not comparable with those "
        "of a GPU. What carries over are images, counts of work and memory."));
  }
  for (std::string label : origins.labels) {
    if (const std::size_t at = label.find(" is a stand-in for "); at != std::string::npos) {
      label = label.substr(0, label.size() - std::string_view(" volume").size());
      label += " voxels: a generated volume, its rates are not those of the original";
    }
    notes.push_back(Note().given(label).own("."));
  }
}

void add_published_note(const PublishedOrigin& published, std::vector<Note>& notes) {
  Note note;
  note.own("Published: ").given(published.citation).own("; ").given(published.title).own(".");
  if (!published.hardware.empty()) note.own(" Times there: ").given(published.hardware).own(".");
  notes.push_back(std::move(note));
}

void add_status_notes(const std::vector<TableLine>& lines, std::vector<Note>& notes) {
  std::map<std::string, std::vector<std::string>> reasons;
  std::size_t not_run = 0;
  for (const TableLine& line : lines) {
    for (const auto& [stage, row] : line.rows) {
      if (row == nullptr) {
        ++not_run;
        continue;
      }
      if (row->is_ok()) continue;
      add_once(reasons[fmt::format("{} {}: {}", stage, row->status, row->reason)],
               name_in_status(line, row->status == kDataMissing));
    }
  }
  for (const auto& [reason, who] : reasons) {
    notes.push_back(
        Note().given(reason).own(" (").given(fmt::format("{}", fmt::join(who, ", "))).own(")"));
  }
  if (not_run > 0) notes.push_back(Note().own(fmt::format("{} cells have not been run.", not_run)));
}

}  // namespace cvr::experiments
