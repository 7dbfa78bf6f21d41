#include "experiments/results/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace cvr::experiments {
namespace {

TEST(Statistics, KnownValuesOfNineSamples) {
  const std::vector<double> samples{9, 1, 8, 2, 7, 3, 6, 4, 5};
  const Statistics s = summarize(samples);
  EXPECT_EQ(s.n, 9u);
  EXPECT_DOUBLE_EQ(s.median, 5);
  EXPECT_DOUBLE_EQ(s.lower_quartile, 3);
  EXPECT_DOUBLE_EQ(s.upper_quartile, 7);
  EXPECT_DOUBLE_EQ(s.mad, 2);
  EXPECT_DOUBLE_EQ(s.mean, 5);
  // k = 2: 1 - 2 (1 + 9) / 512.
  EXPECT_DOUBLE_EQ(s.interval_low, 2);
  EXPECT_DOUBLE_EQ(s.interval_high, 8);
  EXPECT_NEAR(s.interval_coverage, 1 - 20.0 / 512, 1e-12);
  EXPECT_DOUBLE_EQ(s.relative_interval(), 6.0 / 5);
}

TEST(Statistics, EvenNumbersAreInterpolated) {
  const Statistics s = summarize(std::vector<double>{4, 1, 3, 2});
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.lower_quartile, 1.75);
  EXPECT_DOUBLE_EQ(s.upper_quartile, 3.25);
  EXPECT_DOUBLE_EQ(s.mad, 1);
}

TEST(Statistics, IntervalRanksOfTheTables) {
  // Ranks of the 95 % interval of the median as printed in tables of nonparametric statistics.
  EXPECT_EQ(median_interval_rank(5), 0u);
  EXPECT_EQ(median_interval_rank(6), 1u);
  EXPECT_EQ(median_interval_rank(9), 2u);
  EXPECT_EQ(median_interval_rank(12), 3u);
  EXPECT_EQ(median_interval_rank(15), 4u);
  EXPECT_EQ(median_interval_rank(20), 6u);
  EXPECT_EQ(median_interval_rank(25), 8u);
  EXPECT_GT(median_interval_coverage(10000, median_interval_rank(10000)), 0.95);
}

TEST(Statistics, OneSampleIsItsOwnMedianAndProvesNothing) {
  const Statistics s = summarize(std::vector<double>{0.25});
  EXPECT_DOUBLE_EQ(s.median, 0.25);
  EXPECT_DOUBLE_EQ(s.mad, 0);
  EXPECT_DOUBLE_EQ(s.interval_coverage, 0);
  EXPECT_TRUE(std::isinf(s.relative_interval()));
  EXPECT_EQ(s.note(), "n = 1");
}

TEST(Statistics, EqualSamples) {
  const Statistics s = summarize(std::vector<double>(11, 3.0));
  EXPECT_DOUBLE_EQ(s.relative_interval(), 0);
  EXPECT_EQ(s.outliers, 0u);
  EXPECT_FALSE(s.bimodal);
  EXPECT_EQ(s.note(), "");
}

TEST(Statistics, OneOutlierIsNamedAndDoesNotMoveTheMedian) {
  const Statistics s =
      summarize(std::vector<double>{1.00, 1.01, 0.99, 1.02, 0.98, 1.00, 1.01, 0.99, 40});
  EXPECT_DOUBLE_EQ(s.median, 1.00);
  EXPECT_EQ(s.outliers, 1u);
  EXPECT_EQ(s.note(), "1 outlier");
}

TEST(Statistics, TwoModesAreNamed) {
  const Statistics s =
      summarize(std::vector<double>{1.0, 1.01, 1.02, 1.0, 1.01, 2.0, 2.01, 2.02, 2.0, 2.01});
  EXPECT_TRUE(s.bimodal);
  EXPECT_EQ(s.note(), "bimodal");
  EXPECT_FALSE(summarize(std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10}).bimodal);
}

TEST(Statistics, AClockThatDoesNotAdvanceNeverConverges) {
  const Statistics s = summarize(std::vector<double>(9, 0.0));
  EXPECT_TRUE(std::isinf(s.relative_interval()));
  EXPECT_EQ(s.note(), "the clock did not advance");
}

TEST(Statistics, RefusesNothingAndNotANumber) {
  EXPECT_THROW(summarize({}), std::invalid_argument);
  EXPECT_THROW(summarize(std::vector<double>{1, std::numeric_limits<double>::quiet_NaN()}),
               std::invalid_argument);
}

}  // namespace
}  // namespace cvr::experiments
