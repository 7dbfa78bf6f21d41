// Transform, zones, classes.
#include "codecs/tvq/transform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

#include "tests/samples/sample_volumes.hpp"

namespace cvr::codecs::tvq {
namespace {

/// Samples 0..255 by a stateless random number.
std::vector<float> random_blocks(std::size_t blocks, std::uint64_t seed) {
  std::vector<float> samples(blocks * kBlockVoxels);
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i] = static_cast<float>(samples::random_at(seed, i) % 256);
  return samples;
}

double energy(std::span<const float> values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v) * static_cast<double>(v);
  return sum;
}

TEST(Transform, PartitionOrderPutsEveryCoefficientIntoItsOctant) {
  const auto place = partition_order();
  std::set<unsigned> places;
  for (unsigned o = 0; o < kBlockVoxels; ++o) {
    places.insert(place[o]);
    const unsigned octant = ((o & 3) >= 2) + 2 * ((o >> 2 & 3) >= 2) + 4 * ((o >> 4) >= 2);
    const unsigned high = (octant & 1) + (octant >> 1 & 1) + (octant >> 2);
    const unsigned partition = place[o] == 0 ? 0 : place[o] < 8 ? 0 : place[o] < 32 ? 1 : 2;
    EXPECT_EQ(partition, std::min(high, 2u)) << o;
  }
  EXPECT_EQ(places.size(), kBlockVoxels);
  EXPECT_EQ(place[0], 0u);
}

TEST(Transform, KeepsEnergyAndComesBack) {
  const std::vector<float> blocks = random_blocks(500, 3);
  for (const TransformKind kind :
       {TransformKind::kDct, TransformKind::kKltSeparable, TransformKind::kKltFull}) {
    const Basis basis = Basis::fit(kind, blocks, 2);
    std::vector<float> coefficients = blocks;
    basis.forward(coefficients, 2);
    EXPECT_NEAR(energy(coefficients) / energy(blocks), 1.0, 2e-4);
    for (std::size_t b = 0; b < 20; ++b) {
      const auto voxels =
          basis.inverse(std::span(coefficients).subspan(b * kBlockVoxels, kBlockVoxels));
      for (unsigned i = 0; i < kBlockVoxels; ++i)
        ASSERT_NEAR(voxels[i], blocks[b * kBlockVoxels + i], 0.2);
    }
    for (unsigned k = 0; k < kBlockVoxels; ++k) {
      for (unsigned l = 0; l <= k; ++l) {
        double product = 0;
        for (unsigned i = 0; i < kBlockVoxels; ++i)
          product +=
              static_cast<double>(basis.value(k, i)) * static_cast<double>(basis.value(l, i));
        ASSERT_NEAR(product, k == l ? 1 : 0, 1e-3) << k << ' ' << l;
      }
    }
  }
}

TEST(Transform, OfAConstantVolumeIsTheCosineTransform) {
  const std::vector<float> blocks(64 * kBlockVoxels, 93.0f);
  const Basis fitted = Basis::fit(TransformKind::kKltSeparable, blocks, 1);
  const Basis full = Basis::fit(TransformKind::kKltFull, blocks, 1);
  const Basis dct = Basis::dct();
  for (unsigned k = 0; k < kBlockVoxels; ++k) {
    for (unsigned i = 0; i < kBlockVoxels; ++i) {
      EXPECT_NEAR(std::abs(fitted.value(k, i)), std::abs(dct.value(k, i)), 1e-4);
      EXPECT_NEAR(std::abs(full.value(k, i)), std::abs(dct.value(k, i)), 1e-4);
    }
  }
  std::vector<float> coefficients = blocks;
  fitted.forward(coefficients, 1);
  for (std::size_t i = 0; i < coefficients.size(); ++i)
    ASSERT_EQ(coefficients[i], i % kBlockVoxels == 0 ? 8 * 93.0f : 0.0f);
}

TEST(Transform, OfAVolumeThatIsTheSameAlongAllAxesIsToo) {
  // f(x) + f(y) + f(z) with the sum over all shifts: symmetric under exchange of axes.
  std::vector<float> blocks;
  for (std::uint64_t bx = 0; bx < 5; ++bx) {
    for (std::uint64_t by = 0; by < 5; ++by) {
      for (std::uint64_t bz = 0; bz < 5; ++bz) {
        for (unsigned i = 0; i < kBlockVoxels; ++i) {
          const auto f = [](std::uint64_t n) { return samples::random_at(9, n) % 80; };
          blocks.push_back(static_cast<float>(f(bx * 4 + (i & 3)) + f(by * 4 + (i >> 2 & 3)) +
                                              f(bz * 4 + (i >> 4))));
        }
      }
    }
  }
  const Basis basis = Basis::fit(TransformKind::kKltSeparable, blocks, 2);
  const auto stored = basis.stored();
  ASSERT_EQ(stored.size(), 48u);
  EXPECT_TRUE(std::equal(stored.begin(), stored.begin() + 16, stored.begin() + 16));
  EXPECT_TRUE(std::equal(stored.begin(), stored.begin() + 16, stored.begin() + 32));
  EXPECT_FALSE(std::equal(stored.begin() + 4, stored.begin() + 8,
                          Basis(TransformKind::kKltSeparable, stored).stored().begin() + 8));
}

TEST(Transform, FitDoesNotDependOnThreads) {
  const std::vector<float> blocks = random_blocks(9001, 5);
  for (const TransformKind kind : {TransformKind::kKltSeparable, TransformKind::kKltFull}) {
    const Basis one = Basis::fit(kind, blocks, 1), three = Basis::fit(kind, blocks, 3);
    EXPECT_TRUE(std::ranges::equal(one.stored(), three.stored()));
  }
}

TEST(Eigenvectors, DiagoniseWithDescendingValues) {
  constexpr unsigned n = 9;
  std::vector<double> a(n * n);
  for (unsigned i = 0; i < n; ++i) {
    for (unsigned j = 0; j <= i; ++j)
      a[i * n + j] = a[j * n + i] =
          static_cast<double>(samples::random_at(2, i * n + j) % 1000) / 100;
  }
  const std::vector<double> q = eigenvectors(a, n);
  double last = 1e300;
  for (unsigned r = 0; r < n; ++r) {
    std::vector<double> image(n, 0.0);
    double value = 0;
    for (unsigned i = 0; i < n; ++i) {
      for (unsigned j = 0; j < n; ++j) image[i] += a[i * n + j] * q[r * n + j];
      value += image[i] * q[r * n + i];
    }
    for (unsigned i = 0; i < n; ++i) EXPECT_NEAR(image[i], value * q[r * n + i], 1e-9);
    EXPECT_LE(value, last + 1e-9);
    last = value;
  }
}

TEST(Classes, TakeTheCheapestThatLosesNoMoreThanTau) {
  std::array<double, kZones> energies{};
  const auto with = [&](std::initializer_list<unsigned> zones) {
    energies.fill(0);
    for (const unsigned t : zones) energies[t] = 64;
    return kBlockClasses[classify(energies, 0.5)].name;
  };
  EXPECT_EQ(with({}), "zero");
  EXPECT_EQ(with({0}), "LP");
  EXPECT_EQ(with({0, 1}), "BPx");
  EXPECT_EQ(with({2}), "BPy");
  EXPECT_EQ(with({3}), "BPz");
  EXPECT_EQ(with({1, 3}), "BPxyz");
  EXPECT_EQ(with({4}), "HPxy");
  EXPECT_EQ(with({2, 5}), "HPxz");
  EXPECT_EQ(with({6}), "HPyz");
  EXPECT_EQ(with({4, 6}), "HPxyz");
  EXPECT_EQ(with({7}), "HPxyz");
  energies.fill(0.01);
  EXPECT_EQ(classify(energies, 0.5), 0u);
  // Of three directions the best, not the first that passes.
  energies.fill(0);
  energies[1] = 10;
  energies[2] = 20;
  EXPECT_EQ(kBlockClasses[classify(energies, 0.4)].name, "BPy");
}

}  // namespace
}  // namespace cvr::codecs::tvq
