// What a run of a configuration would do with each cell, and what that is expected to take.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "experiments/config/config.hpp"
#include "experiments/results/rows.hpp"

namespace cvr::experiments {

enum class Decision : std::uint8_t { kRun, kDone, kUnsupported, kDataMissing };
/// "run", "done", "unsupported", "data-missing".
std::string_view name_of(Decision decision);

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
/// The model where no row tells: a check takes four and a round one pass over the volume; a pass
/// takes 50 Mvoxel/s and thread (memcpy: 1000); random access takes 0.5 s a round. Pictures: 2
/// Mpixel/s, 20 of them in the check, and 4 s to start. Memory: memory_model.hpp.
std::vector<PlannedCell> plan_cells(const Config& config, const Filter& filter,
                                    const Places& places, const std::vector<Row>& rows, bool redo);

}  // namespace cvr::experiments
