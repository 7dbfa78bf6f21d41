// What a metric reads from the rows of a line: a text for tables, and the number behind it for
// claims.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "experiments/results/rows.hpp"

namespace cvr::experiments {

struct Interval {
  double low, high;
};

struct Reading {
  std::string text;  ///< "" where there is none; the status where the row that it needs is not ok
  std::optional<double> number;  ///< of what has one; infinity for the PSNR of what is exact
  bool timed = false;  ///< a time, or a speed made of one: the number differs from run to run
  std::optional<Interval> interval;  ///< of a time that was measured often enough

  Reading() = default;
  Reading(const char* only_text) : text(only_text) {}
  Reading(std::string only_text) : text(std::move(only_text)) {}
  Reading(std::string with_text, double value) : text(std::move(with_text)), number(value) {}
};

/// Fewer repetitions of a time have no interval: two that agree by chance would prove what they do
/// not.
inline constexpr std::size_t kLeastRepetitions = 3;

/// The 95 % interval of the median of repeated times, minimum and maximum where there are fewer
/// than six (statistics.hpp); none of fewer than kLeastRepetitions.
std::optional<Interval> interval_of(std::span<const double> samples);

/// The reading as a time whose repetitions are `samples`; by default it has no interval.
Reading timed(Reading reading, std::span<const double> samples = {});

/// The same by the interval that the row states, multiplied by `factor`.
Reading timed(Reading reading, const Repeated& repeated, double factor = 1);

/// The same for the whole of what the row measured a part of (whole_over_part), with four
/// significant digits.
Reading of_whole(Reading reading, const Result& result);

}  // namespace cvr::experiments
