// Statistics of one series of repeated measurements: robust, free of distributional assumptions,
// defined for every n >= 1.
//
// Median and quartiles: linear interpolation between order statistics (Hyndman and Fan 1996, type
// 7). MAD: median of the absolute deviations from the median, not scaled. Interval of the median:
// the order statistics x_(k) and x_(n+1-k) with the largest k whose coverage 1 - 2 P[Binomial(n,
// 1/2) < k] is at least 95 % (David and Nagaraja, Order Statistics, section 7.1); with n < 6 no k
// reaches that, the interval is then minimum..maximum and `interval_coverage` says what it is
// worth. Outlier: farther from the median than 5 x 1.4826 MAD. Bimodal: one gap between
// neighbouring samples is wider than each of the two halves it leaves, both of which hold at least
// a quarter of the samples.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace cvr::experiments {

struct Statistics {
  std::size_t n = 0;
  double minimum = 0, maximum = 0, mean = 0;
  double median = 0, lower_quartile = 0, upper_quartile = 0;
  double mad = 0;
  double interval_low = 0, interval_high = 0;  ///< of the median
  double interval_coverage = 0;  ///< probability that it covers the median, 0 for n = 1
  std::size_t outliers = 0;
  bool bimodal = false;

  /// (high - low) / median of the interval. Infinite while n < 6 or where the median is zero: a
  /// clock that does not advance proves nothing.
  double relative_interval() const;
  /// "", or what a reader of the median should know: "1 outlier", "bimodal", "the clock did not
  /// advance", "n = 3".
  std::string note() const;
};

/// Throws std::invalid_argument when there are no samples or one is not finite.
Statistics summarize(std::span<const double> samples);

/// The q-quantile (0 <= q <= 1) of ascending samples, type 7.
double quantile(std::span<const double> ascending, double q);

/// 1-based rank k of the lower end of the 95 % interval of the median of n samples, 0 if there is
/// none.
std::size_t median_interval_rank(std::size_t n);
/// 1 - 2 P[Binomial(n, 1/2) < k].
double median_interval_coverage(std::size_t n, std::size_t k);

}  // namespace cvr::experiments
