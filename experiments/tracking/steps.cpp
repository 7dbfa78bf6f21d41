#include "experiments/tracking/steps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "experiments/results/statistics.hpp"

namespace cvr::experiments {

namespace {

constexpr double kPricePerCut =
    4;  // times log n: of random series of 10 to 200 figures fewer than 1 in 100 have a step then

double median_of(std::span<const double> values) {
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  return quantile(sorted, 0.5);
}

double deviation(std::span<const double> values) {
  const double median = median_of(values);
  double sum = 0;
  for (const double v : values) sum += std::abs(v - median);
  return sum;
}

/// Mean absolute deviation of one figure, by the median difference of neighbours, for noise of the
/// normal distribution.
double noise_of(std::span<const double> values, double floor) {
  std::vector<double> differences;
  for (std::size_t i = 1; i < values.size(); ++i)
    differences.push_back(std::abs(values[i] - values[i - 1]));
  std::ranges::sort(differences);
  const double sigma =
      differences.empty() ? 0 : quantile(differences, 0.5) / (0.6745 * std::sqrt(2.0));
  return std::max(0.798 * sigma, std::log1p(floor) / 8);
}

}  // namespace

std::vector<Step> find_steps(std::span<const double> figures, double floor) {
  std::vector<double> logs;
  for (const double f : figures) {
    if (!(f > 0) || !std::isfinite(f)) throw std::invalid_argument("a figure is not above 0");
    logs.push_back(std::log(f));
  }
  const std::size_t n = logs.size();
  if (n < 2 * kLeastSegment) return {};
  const double noise = noise_of(logs, floor),
               price = kPricePerCut * std::log(static_cast<double>(n));
  // best[i]: least cost of the first i figures; from[i]: where their last segment begins.
  std::vector<double> best(n + 1, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> from(n + 1, 0);
  best[0] = -price;
  for (std::size_t i = kLeastSegment; i <= n; ++i) {
    for (std::size_t j = 0; j + kLeastSegment <= i; ++j) {
      const double cost = best[j] + price + deviation(std::span(logs).subspan(j, i - j)) / noise;
      if (cost < best[i]) best[i] = cost, from[i] = j;
    }
  }
  std::vector<std::size_t> cuts;
  for (std::size_t i = n; i > 0; i = from[i]) cuts.push_back(from[i]);
  std::ranges::reverse(cuts);  // begins with 0
  std::vector<Step> steps;
  for (std::size_t c = 1, begin = 0; c < cuts.size(); ++c) {
    const std::size_t end = c + 1 < cuts.size() ? cuts[c + 1] : n;
    const double before = median_of(std::span(logs).subspan(begin, cuts[c] - begin));
    const double after = median_of(std::span(logs).subspan(cuts[c], end - cuts[c]));
    if (std::abs(after - before) <= std::log1p(floor)) continue;  // joined to the segment before
    steps.push_back({cuts[c], std::exp(before), std::exp(after)});
    begin = cuts[c];
  }
  return steps;
}

}  // namespace cvr::experiments
