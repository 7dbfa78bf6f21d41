// Makes the result of a cell: what it is, how it ended, what was measured.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/results/measured.hpp"
#include "experiments/results/rows.hpp"
#include "experiments/run/plan.hpp"
#include "experiments/run/raw_copies.hpp"

namespace cvr::experiments {

/// Identity, status, reason and provenance: what needs no measurement.
Result start_result(const PlannedCell& planned, const RawCopy& copy, const Provenance& provenance,
                    const std::string& config_hash, std::string_view status,
                    const std::string& reason);

/// One line on how a cell has ended: what it is, the status, and the reason or the most important
/// time.
std::string describe_end(const PlannedCell& planned, const Result& result);

/// `time`, and what the stage makes of the rounds.
void add_times(const PlannedCell& planned, const Measured& measured, const std::string& stop,
               Parts& parts);

}  // namespace cvr::experiments
