#include "codecs/tvq/allocation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace cvr::codecs::tvq {

std::vector<unsigned> choose_bits(std::span<const BitCurve> curves, double blocks, double budget) {
  std::vector<unsigned> choice(curves.size(), 0), best(curves.size());
  for (std::size_t p = 0; p < curves.size(); ++p) best[p] = curves[p].first;
  double least = std::numeric_limits<double>::infinity(), fewest = least;
  for (;;) {
    double distortion = 0, cost = 0, bits = 0;
    for (std::size_t p = 0; p < curves.size(); ++p) {
      distortion += curves[p].distortion[choice[p]];
      cost += curves[p].book_bits[choice[p]];
      bits += curves[p].first + choice[p];
    }
    if (cost + blocks * bits <= budget &&
        (distortion < least || (distortion == least && bits < fewest))) {
      least = distortion;
      fewest = bits;
      for (std::size_t p = 0; p < curves.size(); ++p) best[p] = curves[p].first + choice[p];
    }
    std::size_t p = 0;
    while (p < curves.size() && ++choice[p] == curves[p].distortion.size()) choice[p++] = 0;
    if (p == curves.size()) return best;
  }
}

std::vector<double> model_curve(unsigned dimensions, double variance, double blocks,
                                unsigned most) {
  std::vector<double> curve;
  for (unsigned b = 0; b <= most; ++b)
    curve.push_back(blocks * dimensions * variance * std::exp2(-2.0 * b / dimensions));
  return curve;
}

std::vector<std::uint32_t> share_entries(std::span<const ChapterDemand> demands,
                                         std::uint32_t entries) {
  // N_c(lambda) falls as lambda rises; halvings on a logarithmic scale find the lambda that spends
  // all entries.
  const auto wanted = [&](std::size_t c, double log_lambda) {
    const ChapterDemand& d = demands[c];
    if (d.dimensions == 0 || !(d.amplitude > 0)) return 1.0;
    const double k = d.dimensions;
    const double log_n = (std::log(2 * d.probability * d.amplitude / k) - log_lambda) * k / (k + 2);
    return std::clamp(std::exp(std::min(log_n, 40.0)), 1.0,
                      static_cast<double>(std::max(d.most, 1u)));
  };
  double low = -1500, high = 1500;
  for (unsigned pass = 0; pass < 100; ++pass) {
    const double middle = (low + high) / 2;
    double sum = 0;
    for (std::size_t c = 0; c < demands.size(); ++c) sum += wanted(c, middle);
    (sum > static_cast<double>(entries) ? low : high) = middle;
  }
  std::vector<std::uint32_t> share(demands.size());
  std::vector<double> remainder(demands.size());
  std::uint64_t spent = 0;
  for (std::size_t c = 0; c < demands.size(); ++c) {
    const double n = wanted(c, high);
    share[c] = static_cast<std::uint32_t>(n);
    remainder[c] = n - share[c];
    spent += share[c];
  }
  std::vector<std::size_t> order(demands.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return remainder[a] > remainder[b]; });
  for (bool given = true; given && spent < entries;) {
    given = false;
    for (const std::size_t c : order) {
      if (spent == entries || share[c] >= demands[c].most) continue;
      ++share[c];
      ++spent;
      given = true;
    }
  }
  return share;
}

}  // namespace cvr::codecs::tvq
