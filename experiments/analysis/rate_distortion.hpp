// Curves of error over rate: which points are worth having, and how far two curves are apart.
//
// BD-PSNR (Bjontegaard: Calculation of average PSNR differences between RD-curves, ITU-T VCEG-M33,
// 2001), with monotone piecewise cubics (Fritsch and Carlson 1980; slopes at the points by Fritsch
// and Butland 1984, at the ends by three points, as PCHIP does) in place of one cubic through all
// points, which swings between points that are far apart: PSNR over the logarithm of the rate,
// integrated exactly over the interval that both curves have, the difference divided by the length
// of the interval.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "volumes/error.hpp"

namespace cvr::experiments {

struct RatePoint {
  double bits_per_voxel;  ///< > 0
  double psnr_db;         ///< infinity where exact; or what else is the better the larger it is
};

/// Whether each point is worth having: no other has at most its bits and at least its PSNR, one of
/// both strictly. Of equal points all are.
std::vector<bool> pareto_front(std::span<const RatePoint> points);

struct BdPsnr {
  double db;                        ///< mean PSNR of the tested curve minus that of the reference
  double least_bits, largest_bits;  ///< the common interval
};

inline constexpr std::size_t kLeastCurvePoints = 4;

/// Points off a curve's own front are left out, and those that are exact, since they have no PSNR.
/// Refuses (kBadArgument, saying why) curves of fewer than four points and curves whose rates have
/// no interval in common.
volumes::Expected<BdPsnr> bd_psnr(std::span<const RatePoint> reference,
                                  std::span<const RatePoint> tested);

}  // namespace cvr::experiments
