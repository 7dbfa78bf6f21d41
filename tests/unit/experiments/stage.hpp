// A stage by its id, for cells that tests make.
#pragma once

#include "experiments/stages/stage_kind.hpp"

namespace cvr::experiments {

inline const StageTraits* stage(std::string_view id) { return find_stage(stage_traits(), id); }

}  // namespace cvr::experiments
