#include "experiments/analysis/reading.hpp"

#include <fmt/format.h>

#include "experiments/results/statistics.hpp"

namespace cvr::experiments {

std::optional<Interval> interval_of(std::span<const double> samples) {
  if (samples.size() < kLeastRepetitions) return std::nullopt;
  const Statistics statistics = summarize(samples);
  return Interval{statistics.interval_low, statistics.interval_high};
}

namespace {

Interval scaled(const Interval& interval, double factor) {
  return {factor * interval.low, factor * interval.high};
}

}  // namespace

Reading timed(Reading reading, std::span<const double> samples) {
  reading.timed = true;
  reading.interval = interval_of(samples);
  return reading;
}

Reading timed(Reading reading, const Repeated& repeated, double factor) {
  reading.timed = true;
  if (repeated.samples.size() >= kLeastRepetitions)
    reading.interval = scaled({repeated.interval[0], repeated.interval[1]}, factor);
  return reading;
}

Reading of_whole(Reading reading, const Result& result) {
  if (!reading.number) return reading;
  const double factor = whole_over_part(result);
  reading.number = factor * *reading.number;
  reading.text = fmt::format("{:.4g}", *reading.number);
  if (reading.interval) reading.interval = scaled(*reading.interval, factor);
  return reading;
}

}  // namespace cvr::experiments
