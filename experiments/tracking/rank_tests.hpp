// Two series of times against each other, by ranks alone: no assumption on how times are
// distributed.
//
// Independent series: Mann and Whitney's U test (1947), and the ratio of Hodges and Lehmann (1963),
// the median of all ratios new / base, with the interval that the test's own distribution gives.
// Its distribution is counted exactly while there are no ties and at most kMostExact samples; else
// it is normal, with corrections for ties and continuity.
//
// Series measured in pairs, one of each build a round: the sign test (Arbuthnot 1710) and the
// median of the pairs' ratios with the interval of its order statistics. On shared machines bursts
// of other work hit single rounds; a test that weighs pairs by the size of their difference, as
// Wilcoxon's does, then needs several times the rounds.
#pragma once

#include <cstddef>
#include <span>

namespace cvr::experiments {

inline constexpr std::size_t kMostExact = 60;  ///< samples of both series together

/// P that ranks differ as much or more where both series come from one distribution; both sides
/// together, 0 < p <= 1. 1 for an empty series. Throws std::invalid_argument for a sample that is
/// not finite.
double mann_whitney_p(std::span<const double> base, std::span<const double> fresh);

/// The same for pairs where base is as often above as below; pairs of equal samples count for
/// neither. Throws for series of different lengths too.
double sign_test_p(std::span<const double> base, std::span<const double> fresh);

/// How much longer the new series takes: new / base.
struct RatioEstimate {
  double ratio;
  double low, high;  ///< 0 and infinity where too few samples were taken for the coverage asked for
  double coverage;   ///< probability that low..high covers the ratio; 0 where there is no interval
};
/// Samples above 0. `coverage`: at least, 0 < coverage < 1. Throws std::invalid_argument for an
/// empty series or a sample that is not above 0.
RatioEstimate ratio_of(std::span<const double> base, std::span<const double> fresh,
                       double coverage = 0.95);
/// Of pairs base[i], fresh[i], with 95 %. Throws std::invalid_argument for series of different
/// lengths too.
RatioEstimate paired_ratio(std::span<const double> base, std::span<const double> fresh);

}  // namespace cvr::experiments
