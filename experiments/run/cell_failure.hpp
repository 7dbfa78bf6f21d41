// How a cell that did not come to its end is told in its row.
#pragma once

#include <string>

#include "experiments/run/worker_process.hpp"

namespace cvr::experiments {

struct CellFailure {
  std::string status, reason;
  bool environment = false;  ///< the machine's fault: nothing is said of the codec
};

/// Ends the worker. `outcome` and `message` are of the last wait for it, other than kInterrupted
/// and a sound answer; `when` names what it was asked for: "the check", "round 3".
CellFailure end_and_explain(WorkerProcess& worker, WorkerProcess::Wait outcome, const Row& message,
                            const std::string& when, double timeout_s, const WorkerLimits& limits);

}  // namespace cvr::experiments
