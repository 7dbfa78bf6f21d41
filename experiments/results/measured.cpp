#include "experiments/results/measured.hpp"

#include <algorithm>
#include <limits>

#include "experiments/results/statistics.hpp"

namespace cvr::experiments {

void Measured::add(const std::vector<Sample>& samples) {
  for (const Sample& sample : samples) {
    auto at = std::ranges::find(series, sample.series, &Series::name);
    if (at == series.end())
      at = series.insert(series.end(), {sample.series, sample.count, {}, {}, {}});
    at->wall_seconds.push_back(sample.wall_seconds);
    at->cpu_seconds.push_back(sample.cpu_seconds);
    at->counts.push_back(sample.count);
  }
  ++rounds;
}

double Measured::relative_interval() const {
  if (series.empty()) return std::numeric_limits<double>::infinity();
  return summarize(series.front().wall_seconds).relative_interval();
}

Repeated describe_samples(std::span<const double> samples) {
  const Statistics s = summarize(samples);
  return {.median = s.median,
          .mad = s.mad,
          .lower_quartile = s.lower_quartile,
          .upper_quartile = s.upper_quartile,
          .interval = {s.interval_low, s.interval_high},
          .interval_coverage = s.interval_coverage,
          .minimum = s.minimum,
          .maximum = s.maximum,
          .mean = s.mean,
          .note = s.note(),
          .samples = {samples.begin(), samples.end()}};
}

}  // namespace cvr::experiments
