// Rank tests against values counted by hand or found in tables, and against simulation.
#include "experiments/tracking/rank_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

namespace cvr::experiments {
namespace {

using Series = std::vector<double>;

TEST(MannWhitney, CountsTheWaysToDrawRanks) {
  EXPECT_DOUBLE_EQ(mann_whitney_p(Series{1, 2, 3}, Series{4, 5, 6}), 2.0 / 20);
  EXPECT_DOUBLE_EQ(mann_whitney_p(Series{6, 7, 8, 9, 10}, Series{1, 2, 3, 4, 5}), 2.0 / 252);
  // U = 1 and U = 0 can be had in one way each.
  EXPECT_DOUBLE_EQ(mann_whitney_p(Series{1, 2, 3, 4, 6}, Series{5, 7, 8, 9, 10}), 4.0 / 252);
  // Milton's table (1964): n = 6, m = 8, P[U <= 8] = 0.0213 to four places.
  EXPECT_NEAR(mann_whitney_p(Series{1, 2, 3, 4, 9, 10}, Series{5, 6, 7, 8, 11, 12, 13, 14}) / 2,
              0.0213, 5e-4);
  EXPECT_DOUBLE_EQ(mann_whitney_p(Series{1, 4}, Series{2, 3}), 1);
}

TEST(MannWhitney, IsDefinedForAnySeries) {
  EXPECT_EQ(mann_whitney_p(Series{}, Series{1}), 1);
  EXPECT_EQ(mann_whitney_p(Series{2, 2, 2}, Series{2, 2}), 1);
  EXPECT_LT(mann_whitney_p(Series(20, 1.0), Series(20, 2.0)), 1e-6);
  EXPECT_THROW(mann_whitney_p(Series{1, NAN}, Series{1}), std::invalid_argument);
  // Many samples: the normal distribution goes on where counting ends.
  Series low(30), high(30);
  std::iota(low.begin(), low.end(), 0.0);
  std::iota(high.begin(), high.end(), 3.5);
  const double counted = mann_whitney_p(low, high);
  low.push_back(30);
  high.push_back(33.5);
  EXPECT_NEAR(mann_whitney_p(low, high) / counted, 1, 0.1);
}

TEST(SignTest, CountsTheSigns) {
  const Series base{1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  EXPECT_DOUBLE_EQ(sign_test_p(base, Series{2, 2, 2, 2, 2, 2, 2, 2, 2, 2}), 2.0 / 1024);
  EXPECT_NEAR(sign_test_p(base, Series{0, 2, 2, 2, 2, 2, 2, 2, 2, 2}), 22.0 / 1024, 1e-12);
  EXPECT_NEAR(sign_test_p(base, Series{0.1, 2, 2, 2, 2, 2, 2, 2, 2, 1}), 20.0 / 512,
              1e-12);  // an equal pair counts for neither
  EXPECT_EQ(sign_test_p(base, base), 1);
  EXPECT_EQ(sign_test_p(Series{}, Series{}), 1);
  EXPECT_THROW(sign_test_p(base, Series{1}), std::invalid_argument);
}

TEST(Ratio, OfIndependentSeriesIsTheMedianOfAllRatios) {
  const RatioEstimate same = ratio_of(Series{1, 2, 3, 4, 5}, Series{2, 4, 6, 8, 10});
  EXPECT_NEAR(same.ratio, 2, 1e-12);
  EXPECT_NEAR(same.coverage, 1 - 2 * 4.0 / 252, 1e-12);  // U <= 2 in 1 + 1 + 2 ways
  EXPECT_LT(same.low, 2);
  EXPECT_GT(same.high, 2);
  // Two samples a series have no interval of 95 %.
  const RatioEstimate few = ratio_of(Series{1, 2}, Series{1, 2});
  EXPECT_EQ(few.coverage, 0);
  EXPECT_EQ(few.low, 0);
  EXPECT_TRUE(std::isinf(few.high));
  EXPECT_THROW(ratio_of(Series{}, Series{1}), std::invalid_argument);
  EXPECT_THROW(ratio_of(Series{0}, Series{1}), std::invalid_argument);
}

TEST(Ratio, OfPairsDoesNotSeeWhatBothShare) {
  // A machine that gets slower and slower; every pair has the ratio 1.1.
  Series base, fresh;
  for (int i = 0; i < 12; ++i) {
    base.push_back(1 + i);
    fresh.push_back(1.1 * (1 + i));
  }
  const RatioEstimate estimate = paired_ratio(base, fresh);
  EXPECT_NEAR(estimate.ratio, 1.1, 1e-12);
  EXPECT_NEAR(estimate.low, 1.1, 1e-12);
  EXPECT_NEAR(estimate.high, 1.1, 1e-12);
  EXPECT_GE(estimate.coverage, 0.95);
  EXPECT_THROW(paired_ratio(Series{1, 2}, Series{1}), std::invalid_argument);
}

TEST(Ratio, IntervalsCoverTheTruthAsOftenAsTheySay) {
  std::mt19937_64 random(7);
  std::lognormal_distribution<double> noise(0, 0.2);
  int apart = 0, paired = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    Series base, fresh;
    for (int i = 0; i < 9; ++i) {
      base.push_back(noise(random));
      fresh.push_back(1.3 * noise(random));
    }
    const RatioEstimate a = ratio_of(base, fresh), p = paired_ratio(base, fresh);
    apart += a.low <= 1.3 && 1.3 <= a.high;
    paired += p.low <= 1.3 && 1.3 <= p.high;
  }
  EXPECT_GE(apart, 0.94 * kTrials);
  EXPECT_GE(paired, 0.94 * kTrials);
}

}  // namespace
}  // namespace cvr::experiments
