// Results of hand-made rows.
#pragma once

#include <vector>

#include "experiments/results/result.hpp"

namespace cvr::experiments {

inline std::vector<Result> results_of(const std::vector<Row>& rows) {
  std::vector<Result> results;
  for (const Row& row : rows) results.push_back(from_json<Result>(row));
  return results;
}

}  // namespace cvr::experiments
