#include "experiments/run/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "codecs/registry.hpp"
#include "experiments/run/memory_model.hpp"
#include "experiments/stages/stage_kind.hpp"

namespace cvr::experiments {

namespace {

/// The reason why a codec cannot run a cell, as far as its traits tell.
std::string unsupported_reason(const Cell& cell, const volumes::VolumeInfo& info) {
  if (cell.codec == kMemcpy) return "";
  const auto& traits = codecs::find_codec(cell.codec)->traits();
  if (const auto accepted = codecs::accepts(traits, info); !accepted)
    return accepted.error().message;
  return kind_of(cell).unsupported_reason(cell, traits, info);
}

}  // namespace

std::vector<PlannedCell> plan_cells(const Config& config, const Filter& filter,
                                    const Places& places, const std::vector<Result>& rows,
                                    bool redo) {
  const auto latest = latest_by(rows, &Result::cell);
  const MemoryForecast memory(
      rows, {static_cast<std::uint64_t>(config.memory_limit_gib * (1 << 30)), config.lods});
  std::map<std::string, std::shared_ptr<const Location>> locations;
  std::vector<PlannedCell> plan;
  for (const Cell& cell : config.cells) {
    if (!filter.keeps(cell)) continue;
    PlannedCell planned;
    planned.cell = cell;
    const std::string place = fmt::format(
        "{}|{}|{}|{}|{}", cell.dataset->name, to_string(cell.dataset->generated_extent()),
        cell.dataset->exchange_axes, cell.dataset->axes, cell.dataset->allow_external);
    auto& location = locations[place];
    if (!location) location = std::make_shared<Location>(locate(*cell.dataset, places));
    planned.location = location;
    planned.id = cell_id(cell, location->present ? location->identity : "absent");
    const auto row = latest.find(planned.id);
    if (!location->present) {
      planned.decision = Decision::kDataMissing;
      planned.reason = location->missing;
    } else if (planned.reason = unsupported_reason(cell, location->info); !planned.reason.empty()) {
      planned.decision = Decision::kUnsupported;
    } else if (!redo && row != latest.end() && row->second.is_ok()) {
      planned.decision = Decision::kDone;
    }
    if (location->present && planned.decision != Decision::kUnsupported) {
      planned.expected_seconds =
          kind_of(cell).expected_seconds(cell, location->info, static_cast<double>(config.rounds));
      planned.expected_memory = memory.of(cell, planned.id, location->info);
    }
    if (row != latest.end() && row->second.elapsed_seconds) {
      planned.expected_seconds = *row->second.elapsed_seconds;
      planned.expected_from_rows = true;
    }
    plan.push_back(std::move(planned));
  }
  return plan;
}

}  // namespace cvr::experiments
