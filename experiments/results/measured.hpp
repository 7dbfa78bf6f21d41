// The samples of a cell, round by round, and their aggregates as rows store them: computed once, here,
// and read by tables, claims, tracking and the report.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "experiments/results/result.hpp"
#include "experiments/results/samples.hpp"

namespace cvr::experiments {

/// Samples by series, in the order of the first round; wall and CPU seconds as measured.
struct Measured {
  struct Series {
    std::string name;
    std::uint64_t count = 0;
    std::vector<double> wall_seconds, cpu_seconds;
    std::vector<std::uint64_t> counts;
  };
  std::vector<Series> series;
  std::size_t rounds = 0;

  void add(const std::vector<Sample>& samples);
  /// The relative 95 % interval of the median of the first series' wall time.
  double relative_interval() const;
};

Repeated describe_samples(std::span<const double> samples);

}  // namespace cvr::experiments
