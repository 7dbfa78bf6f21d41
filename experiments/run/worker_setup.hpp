// What a worker is told to do, and how far it may go.
#pragma once

#include "experiments/run/plan.hpp"
#include "experiments/run/raw_copies.hpp"
#include "experiments/run/run_folder.hpp"
#include "experiments/run/worker_process.hpp"
#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

/// Makes the folder of kept images where the cell keeps some.
WorkerSpec make_spec(const Config& config, const PlannedCell& planned, const RawCopy& copy,
                     const RunFolder& folder);

/// Beyond what a sound cell can need: as much processor time as the whole machine gives until its
/// parent would have ended it, and files of half the free disk.
WorkerLimits limits_of(const Config& config, const WorkerSpec& spec);

/// What `PROGRAM --version` says in brackets. Throws EnvironmentError.
std::string revision_of(const std::string& program);

}  // namespace cvr::experiments
