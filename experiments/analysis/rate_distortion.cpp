#include "experiments/analysis/rate_distortion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cvr::experiments {

using volumes::ErrorCode;
using volumes::Expected;

namespace {

/// A monotone piecewise cubic through points of ascending x.
class Pchip {
 public:
  Pchip(std::vector<double> x, std::vector<double> y)
      : x_(std::move(x)), y_(std::move(y)), slopes_(x_.size()) {
    const std::size_t last = x_.size() - 1;
    for (std::size_t i = 1; i < last; ++i) {
      const double before = secant(i - 1), after = secant(i);
      if (before * after <= 0) continue;  // an extremum is kept where it is
      const double w1 = 2 * width(i) + width(i - 1), w2 = width(i) + 2 * width(i - 1);
      slopes_[i] = (w1 + w2) / (w1 / before + w2 / after);
    }
    slopes_[0] = end_slope(width(0), width(1), secant(0), secant(1));
    slopes_[last] = end_slope(width(last - 1), width(last - 2), secant(last - 1), secant(last - 2));
  }

  /// From a to b, both inside the range of the points.
  double integral(double a, double b) const {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < x_.size(); ++i) {
      const double from = std::max(a, x_[i]), to = std::min(b, x_[i + 1]);
      if (from < to) sum += antiderivative(i, to - x_[i]) - antiderivative(i, from - x_[i]);
    }
    return sum;
  }

 private:
  double width(std::size_t i) const { return x_[i + 1] - x_[i]; }
  double secant(std::size_t i) const { return (y_[i + 1] - y_[i]) / width(i); }

  static double end_slope(double near_width, double far_width, double near_secant,
                          double far_secant) {
    const double slope = ((2 * near_width + far_width) * near_secant - near_width * far_secant) /
                         (near_width + far_width);
    if (slope * near_secant <= 0) return 0;
    if (near_secant * far_secant <= 0 && std::abs(slope) > 3 * std::abs(near_secant))
      return 3 * near_secant;
    return slope;
  }

  /// Of piece i at a distance t from its left point, 0 at t = 0.
  double antiderivative(std::size_t i, double t) const {
    const double h = width(i), s = secant(i);
    const double c2 = (3 * s - 2 * slopes_[i] - slopes_[i + 1]) / h;
    const double c3 = (slopes_[i] + slopes_[i + 1] - 2 * s) / (h * h);
    return t * (y_[i] + t * (slopes_[i] / 2 + t * (c2 / 3 + t * c3 / 4)));
  }

  std::vector<double> x_, y_, slopes_;
};

/// The finite points of the front by ascending rate, each rate once.
std::vector<RatePoint> curve_of(std::span<const RatePoint> points) {
  const std::vector<bool> kept = pareto_front(points);
  std::vector<RatePoint> curve;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (kept[i] && std::isfinite(points[i].psnr_db)) curve.push_back(points[i]);
  }
  std::ranges::sort(curve, {}, &RatePoint::bits_per_voxel);
  const auto same_rate = [](const RatePoint& a, const RatePoint& b) {
    return a.bits_per_voxel == b.bits_per_voxel;
  };
  curve.erase(std::unique(curve.begin(), curve.end(), same_rate), curve.end());
  return curve;
}

Pchip interpolate(const std::vector<RatePoint>& curve) {
  std::vector<double> x, y;
  for (const RatePoint& point : curve) {
    x.push_back(std::log10(point.bits_per_voxel));
    y.push_back(point.psnr_db);
  }
  return {std::move(x), std::move(y)};
}

}  // namespace

std::vector<bool> pareto_front(std::span<const RatePoint> points) {
  std::vector<bool> kept;
  for (const RatePoint& p : points) {
    kept.push_back(std::ranges::none_of(points, [&](const RatePoint& q) {
      return q.bits_per_voxel <= p.bits_per_voxel && q.psnr_db >= p.psnr_db &&
             (q.bits_per_voxel < p.bits_per_voxel || q.psnr_db > p.psnr_db);
    }));
  }
  return kept;
}

Expected<BdPsnr> bd_psnr(std::span<const RatePoint> reference, std::span<const RatePoint> tested) {
  const std::vector<RatePoint> a = curve_of(reference), b = curve_of(tested);
  for (const auto& curve : {a, b}) {
    if (curve.size() < kLeastCurvePoints) {
      return volumes::fail(ErrorCode::kBadArgument,
                           fmt::format("expected curves of {} points or more, found one of {}",
                                       kLeastCurvePoints, curve.size()));
    }
  }
  const double least = std::max(a.front().bits_per_voxel, b.front().bits_per_voxel);
  const double largest = std::min(a.back().bits_per_voxel, b.back().bits_per_voxel);
  if (least >= largest) {
    return volumes::fail(
        ErrorCode::kBadArgument,
        fmt::format(
            "expected rates in common, found {:.4g} to {:.4g} and {:.4g} to {:.4g} bits/voxel",
            a.front().bits_per_voxel, a.back().bits_per_voxel, b.front().bits_per_voxel,
            b.back().bits_per_voxel));
  }
  const double from = std::log10(least), to = std::log10(largest);
  const double difference = interpolate(b).integral(from, to) - interpolate(a).integral(from, to);
  return BdPsnr{difference / (to - from), least, largest};
}

}  // namespace cvr::experiments
