#include "experiments/analysis/reading.hpp"

#include <fmt/format.h>

#include "experiments/results/statistics.hpp"

namespace cvr::experiments {

std::optional<Interval> interval_of(std::span<const double> samples) {
  if (samples.size() < kLeastRepetitions) return std::nullopt;
  const Statistics statistics = summarize(samples);
  return Interval{statistics.interval_low, statistics.interval_high};
}

Reading timed(Reading reading, std::span<const double> samples, double factor) {
  reading.timed = true;
  reading.interval = interval_of(samples);
  if (reading.interval)
    reading.interval = {factor * reading.interval->low, factor * reading.interval->high};
  return reading;
}

Reading of_whole(Reading reading, const Row& row) {
  if (!reading.number) return reading;
  const double factor = whole_over_part(row);
  reading.number = factor * *reading.number;
  reading.text = fmt::format("{:.4g}", *reading.number);
  if (reading.interval)
    reading.interval = {factor * reading.interval->low, factor * reading.interval->high};
  return reading;
}

}  // namespace cvr::experiments
