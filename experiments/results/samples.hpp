// The samples of a round as JSON, in the answers of workers and in the journal: [[series, wall
// seconds, CPU seconds, count], ...].
#pragma once

#include <optional>
#include <vector>

#include "experiments/results/rows.hpp"
#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

Row to_row(const std::vector<Sample>& samples);

/// nullopt where it is anything else: no sample, a missing part, a negative time.
std::optional<std::vector<Sample>> samples_from(const Row& row);

}  // namespace cvr::experiments
