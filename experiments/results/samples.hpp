// What a round measures, and the same as JSON in the answers of workers and in the journal:
// [[series, wall seconds, CPU seconds, count], ...].
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/results/result.hpp"

namespace cvr::experiments {

/// One timed piece of a round.
struct Sample {
  std::string series;
  double wall_seconds = 0, cpu_seconds = 0;
  std::uint64_t count = 0;  ///< voxels, points, frames, or the incomplete pixels of one frame
};

Row to_row(const std::vector<Sample>& samples);

/// nullopt where it is anything else: no sample, a missing part, a negative time.
std::optional<std::vector<Sample>> samples_from(const Row& row);

}  // namespace cvr::experiments
