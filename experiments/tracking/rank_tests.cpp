#include "experiments/tracking/rank_tests.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "experiments/results/statistics.hpp"

namespace cvr::experiments {

namespace {

void require_finite(std::span<const double> samples) {
  if (!std::ranges::all_of(samples, [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument("a sample is not finite");
}

void require_times(std::span<const double> samples) {
  require_finite(samples);
  if (samples.empty()) throw std::invalid_argument("a series without samples");
  if (!std::ranges::all_of(samples, [](double x) { return x > 0; }))
    throw std::invalid_argument("a time is not above 0");
}

void require_pairs(std::span<const double> base, std::span<const double> fresh) {
  if (base.size() != fresh.size())
    throw std::invalid_argument("pairs of series of different lengths");
}

/// Ranks from 1, the mean rank for equal values; `ties`: sum of t^3 - t over groups of t equal
/// values.
std::vector<double> mid_ranks(const std::vector<double>& values, double& ties) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return values[i]; });
  std::vector<double> ranks(values.size());
  ties = 0;
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first;
    while (last < order.size() && values[order[last]] == values[order[first]]) ++last;
    for (std::size_t i = first; i < last; ++i)
      ranks[order[i]] = static_cast<double>(first + 1 + last) / 2;
    const auto t = static_cast<double>(last - first);
    ties += t * t * t - t;
    first = last;
  }
  return ranks;
}

/// Both tails of the normal distribution beyond `distance`, half a step towards the middle first.
double normal_tails(double distance, double variance) {
  if (variance <= 0) return 1;
  return std::min(1.0,
                  std::erfc(std::max(0.0, std::abs(distance) - 0.5) / std::sqrt(2 * variance)));
}

/// P[U = u], u = 0..n m: counts of the ways to draw n of n + m ranks.
std::vector<double> u_distribution(std::size_t n, std::size_t m) {
  // ways[k][u]: k of the ranks so far drawn, with U = u; ranks are added one by one.
  std::vector<std::vector<double>> ways(n + 1, std::vector<double>(n * m + 1, 0));
  ways[0][0] = 1;
  for (std::size_t rank = 1; rank <= n + m; ++rank) {
    for (std::size_t k = std::min(n, rank); k >= 1; --k) {
      // The k-th drawn has rank - k ranks of the other series below it.
      const std::size_t below = rank - k;
      if (below > m) continue;
      for (std::size_t u = n * m + 1; u-- > below;) ways[k][u] += ways[k - 1][u - below];
    }
  }
  const double all = std::accumulate(ways[n].begin(), ways[n].end(), 0.0);
  for (double& w : ways[n]) w /= all;
  return ways[n];
}

/// Of a symmetric distribution over 0..last: both tails from min(value, last - value) outwards.
double both_tails(const std::vector<double>& p, double value) {
  const double last = static_cast<double>(p.size() - 1);
  const auto end = static_cast<std::size_t>(std::floor(std::min(value, last - value)));
  double tail = 0;
  for (std::size_t i = 0; i <= end; ++i) tail += p[i];
  return std::min(1.0, 2 * tail);
}

/// Ends of the interval among ascending estimates whose number of values below the truth has the
/// distribution `below`, 0..estimates.size().
RatioEstimate interval_among(std::vector<double>& estimates, const std::vector<double>& below,
                             double coverage) {
  std::ranges::sort(estimates);
  const std::size_t count = estimates.size();
  const double median =
      count % 2 == 1 ? estimates[count / 2] : (estimates[count / 2 - 1] + estimates[count / 2]) / 2;
  RatioEstimate result{std::exp(median), 0, std::numeric_limits<double>::infinity(), 0};
  double tail = 0;
  for (std::size_t k = 0; 2 * (k + 1) <= count; ++k) {  // estimates[k] and its mirror image
    tail += below[k];
    if (1 - 2 * tail < coverage) break;
    result.low = std::exp(estimates[k]), result.high = std::exp(estimates[count - 1 - k]),
    result.coverage = 1 - 2 * tail;
  }
  return result;
}

/// A normal distribution in whole steps 0..last, for what is too much to count.
std::vector<double> normal_distribution(std::size_t last, double variance) {
  std::vector<double> p(last + 1);
  const double mean = static_cast<double>(last) / 2, scale = std::sqrt(2 * variance);
  const auto up_to = [&](double x) { return 0.5 * std::erfc((mean - x) / scale); };
  for (std::size_t i = 0; i <= last; ++i)
    p[i] = up_to(static_cast<double>(i) + 0.5) - (i == 0 ? 0 : up_to(static_cast<double>(i) - 0.5));
  return p;
}

double u_variance(double n, double m, double ties) {
  return n * m / 12 * (n + m + 1 - ties / ((n + m) * (n + m - 1)));
}

std::vector<double> logarithms(std::span<const double> samples) {
  std::vector<double> logs;
  for (const double x : samples) logs.push_back(std::log(x));
  return logs;
}

}  // namespace

double mann_whitney_p(std::span<const double> base, std::span<const double> fresh) {
  require_finite(base);
  require_finite(fresh);
  const std::size_t n = base.size(), m = fresh.size();
  if (n == 0 || m == 0) return 1;
  std::vector<double> all(base.begin(), base.end());
  all.insert(all.end(), fresh.begin(), fresh.end());
  double ties = 0;
  const std::vector<double> ranks = mid_ranks(all, ties);
  const double sum =
      std::accumulate(ranks.begin(), ranks.begin() + static_cast<std::ptrdiff_t>(n), 0.0);
  const double u = sum - static_cast<double>(n * (n + 1)) / 2;
  if (ties == 0 && n + m <= kMostExact) return both_tails(u_distribution(n, m), u);
  return normal_tails(u - static_cast<double>(n * m) / 2,
                      u_variance(static_cast<double>(n), static_cast<double>(m), ties));
}

double sign_test_p(std::span<const double> base, std::span<const double> fresh) {
  require_finite(base);
  require_finite(fresh);
  require_pairs(base, fresh);
  std::size_t above = 0, below = 0;
  for (std::size_t i = 0; i < base.size(); ++i) {
    above += fresh[i] > base[i];
    below += fresh[i] < base[i];
  }
  return 1 - median_interval_coverage(above + below, std::min(above, below) + 1);
}

RatioEstimate ratio_of(std::span<const double> base, std::span<const double> fresh,
                       double coverage) {
  require_times(base);
  require_times(fresh);
  const std::vector<double> from = logarithms(base), to = logarithms(fresh);
  std::vector<double> ratios;
  for (const double b : from)
    for (const double f : to) ratios.push_back(f - b);
  const std::size_t n = base.size(), m = fresh.size();
  const std::vector<double> below =
      n + m <= kMostExact ? u_distribution(n, m)
                          : normal_distribution(n * m, u_variance(static_cast<double>(n),
                                                                  static_cast<double>(m), 0));
  return interval_among(ratios, below, coverage);
}

RatioEstimate paired_ratio(std::span<const double> base, std::span<const double> fresh) {
  require_times(base);
  require_times(fresh);
  require_pairs(base, fresh);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < base.size(); ++i) ratios.push_back(fresh[i] / base[i]);
  const Statistics s = summarize(ratios);
  if (median_interval_rank(s.n) == 0)
    return {s.median, 0, std::numeric_limits<double>::infinity(), 0};
  return {s.median, s.interval_low, s.interval_high, s.interval_coverage};
}

}  // namespace cvr::experiments
