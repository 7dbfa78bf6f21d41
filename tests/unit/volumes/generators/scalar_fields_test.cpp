// The generators of scalars: that their fields are what they say.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "volumes/generators/generator.hpp"
#include "volumes/generators/strict_math.hpp"

namespace cvr::volumes {
namespace {

std::vector<float> field(std::string_view kind, const Extent& extent,
                         std::map<std::string, double> parameters, std::uint64_t seed = 1) {
  parameters["bits"] = 32;
  const auto source = make_generator(kind, extent, seed, parameters, 2);
  EXPECT_EQ(source->info().kind, VolumeKind::kScalars);
  EXPECT_EQ(source->info().type, VoxelType::kF32);
  const Volume volume = read_all(*source);
  const auto voxels = volume.voxels<float>();
  return {voxels.begin(), voxels.end()};
}

struct Moments {
  double mean = 0, deviation = 0;
};

Moments moments_of(const std::vector<float>& values) {
  double sum = 0, squares = 0;
  for (const double v : values) {
    sum += v;
    squares += v * v;
  }
  const auto n = static_cast<double>(values.size());
  return {sum / n, std::sqrt(squares / n - sum / n * sum / n)};
}

double correlation(const std::vector<float>& a, const std::vector<float>& b) {
  const Moments ma = moments_of(a), mb = moments_of(b);
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - ma.mean) * (b[i] - mb.mean);
  return sum / static_cast<double>(a.size()) / (ma.deviation * mb.deviation);
}

TEST(StrictMath, AgreesWithLibm) {
  for (int i = -4000; i <= 4000; ++i) {
    const double t = i / 613.0;
    EXPECT_NEAR(cos_turns(t), std::cos(2 * M_PI * t), 1e-11) << t;
    EXPECT_EQ(floor_strict(t), std::floor(t)) << t;
  }
  for (int i = -40; i <= 40; ++i)
    EXPECT_NEAR(exp2_strict(i / 10.0) / std::exp2(i / 10.0), 1, 1e-14) << i;
}

TEST(Turbulence, HasItsMomentsAndFillsTheVolume) {
  const Moments m = moments_of(field("turbulence", {96, 90, 84}, {{"largest", 16}}));
  EXPECT_NEAR(m.mean, 0.5, 0.02);
  EXPECT_NEAR(m.deviation, 1.0 / 6, 0.02);
}

TEST(Turbulence, SteeperSpectraAreSmoother) {
  const auto roughness = [](double slope) {
    const Extent e{64, 60, 56};
    const std::vector<float> values =
        field("turbulence", e, {{"slope", slope}, {"smallest", 1}, {"largest", 16}});
    double sum = 0;
    for (std::size_t i = 1; i < values.size(); ++i)
      sum += i % e.x == 0 ? 0 : std::pow(values[i] - values[i - 1], 2);
    return sum;
  };
  EXPECT_GT(roughness(0), 1.5 * roughness(1));
  EXPECT_GT(roughness(1), 1.5 * roughness(2));
  EXPECT_GT(roughness(2), 1.5 * roughness(3));
}

/// Octave k alone, as the field of one octave: amplitudes of two octaves must stand in the ratio
/// that the slope asks for.
TEST(Turbulence, OctavesFollowTheSlope) {
  const Extent e{80, 72, 64};
  const double slope = 2.5;
  const std::vector<float> both =
      field("turbulence", e, {{"slope", slope}, {"smallest", 4}, {"largest", 8}});
  const std::vector<float> fine =
      field("turbulence", e, {{"slope", slope}, {"smallest", 4}, {"largest", 4}});
  const std::vector<float> coarse =
      field("turbulence", e, {{"slope", slope}, {"smallest", 8}, {"largest", 8}});
  // The two octaves are independent, so their correlations with the sum are as their amplitudes.
  EXPECT_NEAR(correlation(both, coarse) / correlation(both, fine), std::exp2((slope - 1) / 2),
              0.15);
}

TEST(Shells, AirIsZeroAndWallsAreDense) {
  const Extent e{70, 64, 58};
  const std::vector<float> values = field("shells", e, {});
  const auto air = static_cast<double>(std::ranges::count(values, 0.0F));
  EXPECT_GT(air / static_cast<double>(values.size()), 0.25);
  EXPECT_LT(air / static_cast<double>(values.size()), 0.9);
  EXPECT_GT(*std::ranges::max_element(values), 0.5F);
  for (const std::uint64_t corner : {std::uint64_t{0}, e.x - 1, e.voxels() - 1})
    EXPECT_EQ(values[corner], 0.0F);
}

TEST(Shells, MoreWallsMeanMoreEdges) {
  const auto edges = [](double shells) {
    const std::vector<float> values =
        field("shells", {96, 90, 84},
              {{"shells", shells}, {"noise", 0}, {"dents", 0}, {"thickness", 3}, {"blur", 0.5}});
    std::uint64_t count = 0;
    for (std::size_t i = 1; i < values.size(); ++i)
      count += std::abs(values[i] - values[i - 1]) > 0.3F ? 1 : 0;
    return count;
  };
  EXPECT_GT(edges(4), edges(1) * 3 / 2);
}

TEST(MarschnerLobb, IsTheFormula) {
  const Extent e{41, 43, 45};
  const std::vector<float> values = field("marschner-lobb", e, {});
  for (std::uint64_t i = 0; i < e.voxels(); i += 7) {
    const auto at = [](std::uint64_t v, std::uint64_t n) {
      return 2.0 * static_cast<double>(v) / static_cast<double>(n - 1) - 1;
    };
    const double x = at(i % e.x, e.x), y = at(i / e.x % e.y, e.y), z = at(i / (e.x * e.y), e.z);
    const double r = std::sqrt(x * x + y * y);
    const double radial = std::cos(2 * M_PI * 6 * std::cos(M_PI * r / 2));
    EXPECT_NEAR(values[i], (1 - std::sin(M_PI * z / 2) + 0.25 * (1 + radial)) / 2.5, 1e-6)
        << x << ' ' << y << ' ' << z;
  }
}

TEST(Moving, OneOctaveThatLivesLongIsCarriedByTheWind) {
  const Extent e{64, 20, 18};
  const std::map<std::string, double> still{
      {"smallest", 8}, {"largest", 8}, {"lifetime", 1e6}, {"velocity", 2}};
  std::map<std::string, double> later = still;
  later["time"] = 3;
  const std::vector<float> before = field("moving", e, still), after = field("moving", e, later);
  for (std::uint64_t i = 0; i < e.voxels(); ++i) {
    if (i % e.x >= 6) {
      EXPECT_NEAR(after[i], before[i - 6], 1e-4) << i;
    }
  }
}

TEST(Moving, StepsAreAlikeWhenNearAndUnlikeWhenFar) {
  const auto at = [](double time) {
    return field("moving", {64, 60, 40}, {{"time", time}, {"largest", 16}, {"velocity", 0.5}});
  };
  const std::vector<float> first = at(0);
  EXPECT_EQ(first, at(0));
  EXPECT_GT(correlation(first, at(1)), 0.7);
  EXPECT_LT(std::abs(correlation(first, at(200))), 0.2);
  EXPECT_NEAR(moments_of(at(7.5)).deviation, 1.0 / 6,
              0.02);  // the variance is kept between two births
}

TEST(Moving, ASeriesIsItsStepsStacked) {
  const Extent e{37, 22, 9};
  std::map<std::string, double> parameters{
      {"bits", 8}, {"time", 2.5}, {"largest", 16}, {"lifetime", 3}};
  const auto with = [&](double time, double steps, unsigned threads) {
    parameters["time"] = time, parameters["steps"] = steps;
    return make_generator("moving", e, 11, parameters, threads);
  };
  const auto series = with(2.5, 4, 3);
  EXPECT_EQ(series->info().extent, (Extent{37, 22, 36}));
  EXPECT_EQ(series->info().time_steps, 4u);
  EXPECT_EQ(series->info().step_extent(), e);
  for (unsigned t = 0; t < 4; ++t) {
    const auto alone = with(2.5 + t, 1, 1);
    EXPECT_EQ(alone->info().time_steps, 1u);
    const Volume expected = read_all(*alone);
    Volume found(alone->info());
    series->read({{0, 0, 9 * t}, e}, found.data());
    EXPECT_EQ(std::memcmp(found.data(), expected.data(), e.voxels()), 0) << t;
  }
  // A box across the border of two steps.
  const Volume whole = read_all(*series);
  const Box box{{3, 5, 7}, {20, 10, 6}};
  std::vector<std::byte> expected(box.size.voxels()), found(expected.size());
  MemorySource(whole).read(box, expected.data());
  series->read(box, found.data());
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace cvr::volumes
