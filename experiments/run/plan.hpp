// What a run of a configuration would do with each cell, and what that is expected to take.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "experiments/config/config.hpp"
#include "experiments/results/rows.hpp"
#include "volumes/enum_names.hpp"

namespace cvr::experiments {

enum class Decision : std::uint8_t { kRun, kDone, kUnsupported, kDataMissing };
inline constexpr auto kDecisionNames =
    volumes::enum_names<Decision>({{Decision::kRun, "run"},
                                   {Decision::kDone, "done"},
                                   {Decision::kUnsupported, "unsupported"},
                                   {Decision::kDataMissing, "data-missing"}});
constexpr std::string_view name_of(Decision decision) { return kDecisionNames.of(decision); }

struct PlannedCell {
  Cell cell;
  std::shared_ptr<const Location> location;
  std::string id;
  Decision decision = Decision::kRun;
  std::string reason;           ///< of unsupported and data-missing
  double expected_seconds = 0;  ///< check and rounds together
  std::uint64_t expected_memory =
      0;  ///< bytes of the worker beyond the mapped input while rounds are timed
  bool expected_from_rows = false;  ///< else from the stated model
};

/// Cells that pass the filter, in the order of the configuration. `rows`: what OUT holds already;
/// cells with a row that is ok are done unless `redo`.
///
/// Where no row tells, the stages' own models do (stages/stage_kind.hpp). Memory: memory_model.hpp.
std::vector<PlannedCell> plan_cells(const Config& config, const Filter& filter,
                                    const Places& places, const std::vector<Result>& rows,
                                    bool redo);

}  // namespace cvr::experiments
