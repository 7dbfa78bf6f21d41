#include "experiments/config/vocabulary.hpp"

#include <algorithm>

namespace cvr::experiments {

const StageTraits* find_stage(StageList stages, std::string_view id) {
  const auto found = std::ranges::find(stages, id, &StageTraits::id);
  return found == stages.end() ? nullptr : *found;
}

}  // namespace cvr::experiments
