// Steps in a series of figures over time: the piecewise-constant fit.
//
// Of all ways to cut the series into segments of at least kLeastSegment figures, the one with the
// least sum of absolute deviations of the logarithms from each segment's median, in units of the
// series' own noise, plus a price a cut (optimal partitioning, Jackson et al. 2005; absolute
// deviations, so that a single bad run is no step). The noise is estimated from the differences of
// neighbours, which steps hardly change. Neighbouring segments that differ by less than the noise
// floor are joined.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cvr::experiments {

inline constexpr std::size_t kLeastSegment = 2;

struct Step {
  std::size_t at;        ///< the first figure of the new level
  double before, after;  ///< medians of the segments on both sides
  double ratio() const { return after / before; }
};

/// Steps of figures above 0, in the order of time. `floor`: relative change that says nothing.
/// Throws std::invalid_argument for a figure that is not above 0 or not finite.
std::vector<Step> find_steps(std::span<const double> figures, double floor);

}  // namespace cvr::experiments
