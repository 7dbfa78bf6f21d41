// Makes the row of a cell: what it is, how it ended, what was measured.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/analysis/statistics.hpp"
#include "experiments/results/rows.hpp"
#include "experiments/run/plan.hpp"
#include "experiments/run/raw_copies.hpp"
#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

/// Samples of a cell by series, in the order of the first round; wall and CPU seconds as measured.
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

/// Identity, status, reason and provenance; the parts of a row that need no measurement.
Row start_row(const PlannedCell& planned, const RawCopy& copy, const Row& provenance,
              const std::string& config_hash, std::string_view status, const std::string& reason);

/// One line on how a cell has ended, of its row: what it is, the status, and the reason or the most
/// important time.
std::string describe_end(const PlannedCell& planned, const Row& row);

/// "time" and, for random access, "access", for the stage render "frames" and what "held" has of
/// times.
void add_times(const PlannedCell& planned, const Measured& measured, const std::string& stop,
               Row& row);

}  // namespace cvr::experiments
