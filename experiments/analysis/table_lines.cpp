#include "experiments/analysis/table_lines.hpp"

#include <algorithm>

namespace cvr::experiments {

std::vector<TableLine> collect_lines(const Filter& where, bool renders, const Config& config,
                                     const std::map<std::string, Result>& latest) {
  std::vector<TableLine> lines;
  std::map<std::string, std::size_t> by_key;
  for (const Cell& cell : config.cells) {
    if (cell.render.has_value() != renders) continue;
    // memcpy has no parameters; conditions on them do not take its line away.
    Filter applicable = where;
    if (cell.codec == kMemcpy) {
      std::erase_if(applicable.only, [](const auto& c) {
        return c.first != "dataset" && c.first != "kind" && c.first != "codec" &&
               c.first != "threads";
      });
    }
    if (!applicable.keeps(cell)) continue;
    const auto [at, added] = by_key.emplace(cell.line_key(), lines.size());
    if (added) lines.push_back({&cell, {}});
    const auto row = latest.find(cell.row_key());
    lines[at->second].rows[cell.stage->id] = row == latest.end() ? nullptr : &row->second;
  }
  // Line order: data sets, then threads, then codecs as the configuration lists them.
  std::map<std::string, std::size_t> dataset_order;
  for (const TableLine& line : lines)
    dataset_order.emplace(line.cell->dataset->name, dataset_order.size());
  std::ranges::stable_sort(
      lines, {}, [&](const TableLine& line) { return dataset_order[line.cell->dataset->name]; });
  return lines;
}

LineContext context_of(const TableLine& line, const std::optional<PublishedTable>& published) {
  return {line.rows, published ? published->find(*line.cell) : nullptr,
          line.cell->codec == kMemcpy};
}

}  // namespace cvr::experiments
