// The speed of light of the table, for stages whose traits ask for it.
#pragma once

#include <memory>

#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

std::unique_ptr<StageRun> make_memcpy_run(const StageInput& input);

}  // namespace cvr::experiments
