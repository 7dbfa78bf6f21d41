// The speed of light of the table, for stages whose traits ask for it.
#pragma once

#include <memory>

#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

/// `truth` outlives the result.
std::unique_ptr<StageRun> make_memcpy_run(const WorkerSpec& spec,
                                          const volumes::VolumeSource& truth);

}  // namespace cvr::experiments
