#include "experiments/results/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace cvr::experiments {

namespace {

constexpr double kConfidence = 0.95;
constexpr double kOutlierMads =
    5 * 1.4826;  // 1.4826 MAD estimates the standard deviation of a normal distribution

std::size_t count_outliers(std::span<const double> samples, double median, double mad) {
  return static_cast<std::size_t>(std::ranges::count_if(samples, [&](double x) {
    return std::abs(x - median) > std::max(kOutlierMads * mad, 0.01 * std::abs(median));
  }));
}

bool is_bimodal(std::span<const double> ascending) {
  const std::size_t n = ascending.size();
  if (n < 8) return false;
  std::size_t cut = 1;
  for (std::size_t i = 2; i < n; ++i) {
    if (ascending[i] - ascending[i - 1] > ascending[cut] - ascending[cut - 1]) cut = i;
  }
  const double gap = ascending[cut] - ascending[cut - 1];
  const double left = ascending[cut - 1] - ascending.front();
  const double right = ascending.back() - ascending[cut];
  return cut * 4 >= n && (n - cut) * 4 >= n && gap > left && gap > right &&
         gap > 0.01 * std::abs(ascending[cut]);
}

}  // namespace

double quantile(std::span<const double> ascending, double q) {
  const double position = q * static_cast<double>(ascending.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, ascending.size() - 1);
  return ascending[below] +
         (position - static_cast<double>(below)) * (ascending[above] - ascending[below]);
}

double median_interval_coverage(std::size_t n, std::size_t k) {
  // Terms C(n, i) / 2^n through their logarithms: 2^n leaves the range of double from n = 1024 on.
  double tail = 0;
  for (std::size_t i = 0; i < k; ++i) {
    const auto dn = static_cast<double>(n), di = static_cast<double>(i);
    tail += std::exp(std::lgamma(dn + 1) - std::lgamma(di + 1) - std::lgamma(dn - di + 1) -
                     dn * std::log(2.0));
  }
  return std::max(0.0, 1 - 2 * tail);
}

std::size_t median_interval_rank(std::size_t n) {
  std::size_t k = 0;
  while (k < (n + 1) / 2 && median_interval_coverage(n, k + 1) >= kConfidence) ++k;
  return k;
}

Statistics summarize(std::span<const double> samples) {
  if (samples.empty()) throw std::invalid_argument("statistics: expected at least one sample");
  if (!std::ranges::all_of(samples, [](double x) { return std::isfinite(x); })) {
    throw std::invalid_argument("statistics: expected finite samples");
  }
  std::vector<double> ascending(samples.begin(), samples.end());
  std::ranges::sort(ascending);
  Statistics s;
  s.n = ascending.size();
  s.minimum = ascending.front();
  s.maximum = ascending.back();
  s.mean = std::accumulate(ascending.begin(), ascending.end(), 0.0) / static_cast<double>(s.n);
  s.median = quantile(ascending, 0.5);
  s.lower_quartile = quantile(ascending, 0.25);
  s.upper_quartile = quantile(ascending, 0.75);
  std::vector<double> deviations;
  for (const double x : ascending) deviations.push_back(std::abs(x - s.median));
  std::ranges::sort(deviations);
  s.mad = quantile(deviations, 0.5);
  const std::size_t k = std::max<std::size_t>(1, median_interval_rank(s.n));
  s.interval_low = ascending[k - 1];
  s.interval_high = ascending[s.n - k];
  s.interval_coverage = median_interval_coverage(s.n, k);
  s.outliers = count_outliers(ascending, s.median, s.mad);
  s.bimodal = is_bimodal(ascending);
  return s;
}

double Statistics::relative_interval() const {
  if (interval_coverage < kConfidence || median <= 0)
    return std::numeric_limits<double>::infinity();
  return (interval_high - interval_low) / median;
}

std::string Statistics::note() const {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (interval_coverage < kConfidence) add(fmt::format("n = {}", n));
  if (median <= 0) add("the clock did not advance");
  if (bimodal) add("bimodal");
  if (outliers > 0 && !bimodal)
    add(fmt::format("{} outlier{}", outliers, outliers == 1 ? "" : "s"));
  return text;
}

}  // namespace cvr::experiments
