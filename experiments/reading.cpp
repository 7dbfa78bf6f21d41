#include "experiments/reading.hpp"

#include "experiments/statistics.hpp"

namespace cvr::experiments {

std::optional<Interval> interval_of(std::span<const double> samples) {
  if (samples.size() < kLeastRepetitions) return std::nullopt;
  const Statistics statistics = summarize(samples);
  return Interval{statistics.interval_low, statistics.interval_high};
}

Reading timed(Reading reading, std::span<const double> samples, double factor) {
  reading.timed = true;
  reading.interval = interval_of(samples);
  if (reading.interval) reading.interval = {factor * reading.interval->low, factor * reading.interval->high};
  return reading;
}

}  // namespace cvr::experiments
