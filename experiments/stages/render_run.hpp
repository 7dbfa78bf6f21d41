// The run of the stage render.
#pragma once

#include <memory>

#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

/// Of labels and scalars; `truth` outlives the result.
std::unique_ptr<StageRun> make_render_run(const WorkerSpec& spec,
                                          const volumes::VolumeSource& truth);

}  // namespace cvr::experiments
