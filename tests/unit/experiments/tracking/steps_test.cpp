// Steps in synthetic series, and baselines.
#include "experiments/tracking/steps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace cvr::experiments {
namespace {

std::vector<double> noisy(const std::vector<double>& levels, double sigma, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> figures;
  for (const double level : levels) figures.push_back(level * std::exp(sigma * normal(random)));
  return figures;
}

std::vector<double> levels(const std::vector<std::pair<int, double>>& parts) {
  std::vector<double> all;
  for (const auto& [count, level] : parts)
    all.insert(all.end(), static_cast<std::size_t>(count), level);
  return all;
}

TEST(Steps, AreFoundWhereTheyAre) {
  const auto found = find_steps(noisy(levels({{10, 1}, {8, 1.2}, {12, 0.9}}), 0.01, 3), 0.05);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].at, 10u);
  EXPECT_NEAR(found[0].ratio(), 1.2, 0.03);
  EXPECT_EQ(found[1].at, 18u);
  EXPECT_NEAR(found[1].ratio(), 0.75, 0.03);
}

TEST(Steps, AreNotFoundInNoiseOutliersAndShortSeries) {
  int wrong = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    wrong += !find_steps(noisy(levels({{40, 1}}), 0.04, seed), 0.05).empty();
  EXPECT_LE(wrong, 2);
  auto outlier = noisy(levels({{20, 1}}), 0.01, 1);
  outlier[7] = 3;
  EXPECT_TRUE(find_steps(outlier, 0.05).empty());
  EXPECT_TRUE(find_steps({}, 0.05).empty());
  EXPECT_TRUE(find_steps(std::vector<double>{1, 2, 2}, 0.05).empty());
  EXPECT_TRUE(find_steps(std::vector<double>(30, 4.0), 0.05).empty());
  // Below the floor.
  EXPECT_TRUE(find_steps(noisy(levels({{20, 1}, {20, 1.03}}), 0.001, 2), 0.05).empty());
  EXPECT_THROW(find_steps(std::vector<double>{1, 0, 1, 1}, 0.05), std::invalid_argument);
}

TEST(Steps, OfTwoNewFiguresAreFound) {
  const auto found = find_steps(noisy(levels({{12, 1}, {2, 1.5}}), 0.01, 9), 0.05);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].at, 12u);
}

TEST(Steps, AreFoundInMostNoisySeries) {
  int hits = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto found = find_steps(noisy(levels({{15, 1}, {15, 1.2}}), 0.04, seed), 0.05);
    hits += found.size() == 1 && found[0].at >= 14 && found[0].at <= 16;
  }
  EXPECT_GE(hits, 90);
}

}  // namespace
}  // namespace cvr::experiments
