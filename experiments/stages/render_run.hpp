// The run of the stage render.
#pragma once

#include <memory>

#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

/// Of labels and scalars.
std::unique_ptr<StageRun> make_render_run(const StageInput& input);

}  // namespace cvr::experiments
