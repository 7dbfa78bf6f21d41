// Bits among partitions, code vectors among classes.
#include "codecs/tvq/allocation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace cvr::codecs::tvq {
namespace {

TEST(Bits, AreTheBestThatFit) {
  std::vector<BitCurve> curves{{0, {90, 50, 31, 22, 17}, {0, 8, 16, 32, 64}},
                               {0, {70, 60, 20, 19}, {0, 5, 10, 20}},
                               {2, {12, 6, 3}, {0, 0, 0}}};
  for (double budget = 10; budget < 200; budget += 7) {
    const std::vector<unsigned> found = choose_bits(curves, 10, budget);
    double best = 1e300;
    for (unsigned a = 0; a < 5; ++a) {
      for (unsigned b = 0; b < 4; ++b) {
        for (unsigned c = 0; c < 3; ++c) {
          if (curves[0].book_bits[a] + curves[1].book_bits[b] + 10.0 * (a + b + c + 2) <= budget) {
            best = std::min(
                best, curves[0].distortion[a] + curves[1].distortion[b] + curves[2].distortion[c]);
          }
        }
      }
    }
    if (best == 1e300) {
      EXPECT_EQ(found, (std::vector<unsigned>{0, 0, 2}));
    } else {
      EXPECT_EQ(curves[0].distortion[found[0]] + curves[1].distortion[found[1]] +
                    curves[2].distortion[found[2] - 2],
                best)
          << budget;
    }
  }
}

TEST(Bits, OfTheModelLieNextToTheRealValuedOptimum) {
  // b_p = (n_p / 2) log2(s2_p / theta) where no bound binds.
  const std::array<double, 3> n{7, 24, 32}, variance{400, 6, 3};
  std::vector<BitCurve> curves;
  for (unsigned p = 0; p < 3; ++p) {
    curves.push_back({0, model_curve(static_cast<unsigned>(n[p]), variance[p], 1, 60), {}});
    curves.back().book_bits.assign(61, 0.0);
  }
  constexpr double kTotal = 60;
  const std::vector<unsigned> found = choose_bits(curves, 1, kTotal);
  double logs = 0, sum = 0;
  for (unsigned p = 0; p < 3; ++p) logs += n[p] / 2 * std::log2(variance[p]), sum += n[p] / 2;
  const double theta = (logs - kTotal) / sum;
  EXPECT_EQ(found[0] + found[1] + found[2], 60u);
  for (unsigned p = 0; p < 3; ++p)
    EXPECT_NEAR(found[p], n[p] / 2 * (std::log2(variance[p]) - theta), 1.0) << p;
}

double distortion_of(std::span<const ChapterDemand> demands, std::span<const std::uint32_t> share) {
  double sum = 0;
  for (std::size_t c = 0; c < demands.size(); ++c) {
    sum += demands[c].probability * demands[c].amplitude *
           std::pow(share[c], -2.0 / demands[c].dimensions);
  }
  return sum;
}

TEST(Chapters, ShareAsTheBestOfAllSharesDoes) {
  const std::vector<ChapterDemand> demands{
      {0.5, 30, 7, 1000}, {0.3, 200, 8, 1000}, {0.2, 50, 24, 1000}};
  for (const std::uint32_t entries : {3u, 9u, 40u}) {
    const std::vector<std::uint32_t> found = share_entries(demands, entries);
    EXPECT_EQ(std::accumulate(found.begin(), found.end(), 0u), entries);
    double best = 1e300;
    for (std::uint32_t a = 1; a < entries; ++a) {
      for (std::uint32_t b = 1; a + b < entries; ++b)
        best = std::min(best, distortion_of(demands, std::array{a, b, entries - a - b}));
    }
    EXPECT_LE(distortion_of(demands, found), best * 1.01) << entries;
  }
}

TEST(Chapters, OfOneDimensionAgreeWithTheClosedForm) {
  // The same k: N_c proportional to (p_c A_c)^(k / (k + 2)).
  const std::vector<ChapterDemand> demands{{0.25, 16, 2, 100000}, {0.75, 3, 2, 100000}};
  const std::vector<std::uint32_t> found = share_entries(demands, 10000);
  const double a = std::sqrt(0.25 * 16), b = std::sqrt(0.75 * 3);
  EXPECT_NEAR(found[0], 10000 * a / (a + b), 1.0);
}

TEST(Chapters, KeepBoundsAndSurviveClassesWithoutVariance) {
  const std::vector<ChapterDemand> demands{{0.9, 1000, 7, 5}, {0.1, 0, 0, 50}, {1e-9, 1e-30, 8, 3}};
  const std::vector<std::uint32_t> found = share_entries(demands, 40);
  EXPECT_EQ(found[0], 5u);
  EXPECT_EQ(found[2], 3u);
  EXPECT_GE(found[1], 1u);
  EXPECT_EQ(share_entries(demands, 100), (std::vector<std::uint32_t>{5, 50, 3}));
}

}  // namespace
}  // namespace cvr::codecs::tvq
