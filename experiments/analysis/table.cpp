#include "experiments/analysis/table.hpp"

#include <algorithm>
#include <array>

#include "volumes/plain_text.hpp"

namespace cvr::experiments {

std::string_view name_of(Align align) { return align == Align::kLeft ? "left" : "right"; }

std::string Note::plain() const {
  std::string text;
  for (const NotePart& part : parts_) text += part.text;
  return volumes::printable(text);
}

void Table::add_label(std::string label, std::string description) {
  TableColumn column;
  column.name = label;
  column.heading = std::move(label);
  column.description = std::move(description);
  column.align = Align::kLeft;
  columns.push_back(std::move(column));
  ++labels;
}

void Table::add_line(std::vector<std::string> texts) {
  LineOfCells line;
  for (std::string& text : texts) line.cells.push_back({std::move(text), {}, {}, {}});
  lines.push_back(std::move(line));
}

std::string_view unit_in(std::string_view heading) {
  static constexpr std::array<std::string_view, 11> kUnits{
      "%", "+-%", "bits/voxel", "dB", "ns", "ms", "s", "GB/s", "Mvoxel/s", "MiB", "px"};
  while (!heading.empty()) {
    const std::size_t end = std::min(heading.find_first_of(" ,;"), heading.size());
    const std::string_view word = heading.substr(0, end);
    if (std::ranges::find(kUnits, word) != kUnits.end()) return word == "+-%" ? "%" : word;
    heading.remove_prefix(std::min(end + 1, heading.size()));
  }
  return "";
}

}  // namespace cvr::experiments
