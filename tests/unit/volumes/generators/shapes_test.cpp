// The stand-ins look like what they stand in for: numbers, sizes and shapes of their labels lie in
// bands around the originals' figures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "volumes/generators/generator.hpp"

namespace cvr::volumes {
namespace {

struct Shape {
  std::uint64_t voxels = 0;
  Coordinate low{~0ull, ~0ull, ~0ull}, high;
};

std::map<std::uint64_t, Shape> shapes_of(const Volume& volume) {
  std::map<std::uint64_t, Shape> shapes;
  const Extent& e = volume.extent();
  for (std::uint64_t z = 0; z < e.z; ++z) {
    for (std::uint64_t y = 0; y < e.y; ++y) {
      for (std::uint64_t x = 0; x < e.x; ++x) {
        Shape& s = shapes[volume.label({x, y, z})];
        ++s.voxels;
        s.low = {std::min(s.low.x, x), std::min(s.low.y, y), std::min(s.low.z, z)};
        s.high = {std::max(s.high.x, x), std::max(s.high.y, y), std::max(s.high.z, z)};
      }
    }
  }
  return shapes;
}

std::uint64_t longest_side(const Shape& s) {
  return 1 + std::max({s.high.x - s.low.x, s.high.y - s.low.y, s.high.z - s.low.z});
}

Volume generate(std::string_view kind, const Extent& extent,
                const std::map<std::string, double>& parameters = {}) {
  return read_all(*make_generator(kind, extent, 1, parameters, 2));
}

double share(std::uint64_t part, std::uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

TEST(Cells, HaveAThousandVoxelsEachAreCompactAndFillTheVolume) {
  const Extent extent{130, 110, 90};
  const Volume volume = generate("cells", extent);
  EXPECT_EQ(volume.info().type, VoxelType::kU32);
  const auto shapes = shapes_of(volume);
  EXPECT_FALSE(shapes.contains(0));
  EXPECT_EQ(shapes.size(), 13u * 11u * 9u);  // CELLS has 1,067,196 in 1000^3: 937 voxels each
  EXPECT_EQ(shapes.rbegin()->first, shapes.size());  // consecutive ids from 1
  std::size_t ordinary = 0, compact = 0;
  for (const auto& [label, shape] : shapes) {
    ordinary += shape.voxels > 400 && shape.voxels < 1800 ? 1 : 0;
    compact += longest_side(shape) < 26 ? 1 : 0;
  }
  EXPECT_GT(share(ordinary, shapes.size()), 0.95);
  EXPECT_GT(share(compact, shapes.size()), 0.99);
}

TEST(Cells, IdsAreScatteredOrInScanOrder) {
  const auto jumps = [](double scatter) {
    const Volume volume = generate("cells", {128, 20, 20}, {{"scatter", scatter}});
    std::uint64_t far = 0, changes = 0;
    for (std::uint64_t x = 1; x < 128; ++x) {
      const auto a = static_cast<std::int64_t>(volume.label({x - 1, 10, 10}));
      const auto b = static_cast<std::int64_t>(volume.label({x, 10, 10}));
      changes += a != b ? 1 : 0;
      far += a != b && std::abs(a - b) != 1 && std::abs(a - b) % 13 > 1 && std::abs(a - b) % 13 < 12
                 ? 1
                 : 0;
    }
    return share(far, changes);
  };
  EXPECT_GT(
      jumps(1),
      0.4);  // neighbours along x differ by 0, 1 or a multiple of the row of 13 boxes only in scan order
  EXPECT_LT(jumps(0), 0.1);
}

TEST(Cells, HeatRoughensTheBorders) {
  const auto faces = [](double heat) {
    const Volume volume = generate("cells", {80, 70, 60}, {{"heat", heat}, {"sweeps", 12}});
    std::uint64_t n = 0;
    for (std::uint64_t i = 1; i < volume.extent().voxels(); ++i) {
      n += volume.voxels<std::uint32_t>()[i] != volume.voxels<std::uint32_t>()[i - 1] ? 1 : 0;
    }
    return n;
  };
  EXPECT_GT(faces(0.9), faces(0) * 11 / 10);
}

TEST(Fibers, AreLongThinNumberedAndRare) {
  const Extent extent{200, 150, 220};
  const Volume volume = generate("fibers", extent);
  EXPECT_EQ(volume.info().type, VoxelType::kU16);
  auto shapes = shapes_of(volume);
  const double background = share(shapes[0].voxels, extent.voxels());
  EXPECT_GT(background, 0.88);
  EXPECT_LT(background, 0.97);
  shapes.erase(0);
  // FIBER has 26,372 in 2.85e9 voxels; a small volume cuts more of them a voxel.
  EXPECT_GT(shapes.size(), 70u);
  EXPECT_LT(shapes.size(), 250u);
  EXPECT_GE(shapes.rbegin()->first, shapes.size());
  EXPECT_LE(shapes.rbegin()->first, shapes.size() * 5 / 4);  // 1 .. n; a few only graze the volume
  std::size_t slender = 0, whole = 0;
  for (const auto& [label, shape] : shapes) {
    if (shape.voxels < 2000) continue;  // cut by the border
    ++whole;
    // Volume over length is the cross-section: that of a radius of about 3 voxels.
    slender += share(shape.voxels, longest_side(shape)) < 60 ? 1 : 0;
  }
  EXPECT_GT(whole, 30u);
  EXPECT_EQ(slender, whole);
}

TEST(Fibers, ManyFibersTakeThirtyTwoBits) {
  const auto source = make_generator("fibers", {1100, 1100, 1100}, 1,
                                     {{"density", 60}, {"length", 20}, {"attempts", 1}}, 2);
  EXPECT_EQ(source->info().type, VoxelType::kU32);
}

TEST(Neurites, AreInterleavedOfUnequalSizeWithSomeBackground) {
  const Extent extent{200, 180, 160};
  const Volume volume = generate("neurites", extent);
  EXPECT_EQ(volume.info().type, VoxelType::kU32);
  auto shapes = shapes_of(volume);
  const double background = share(shapes[0].voxels, extent.voxels());
  EXPECT_GT(background, 0.0005);
  EXPECT_LT(background, 0.1);
  shapes.erase(0);
  EXPECT_GT(shapes.size(), 60u);
  EXPECT_LT(shapes.size(), 400u);
  EXPECT_LE(shapes.rbegin()->first, 1296889u);
  EXPECT_GT(shapes.rbegin()->first, 1000000u);  // ids of a crop: spread over those of the whole
  std::vector<std::uint64_t> sizes;
  for (const auto& [label, shape] : shapes) sizes.push_back(shape.voxels);
  std::sort(sizes.begin(), sizes.end());
  EXPECT_GT(sizes.back(), 10 * sizes[sizes.size() / 2]);
}

TEST(Neurites, IdsStayInTheirRange) {
  const Volume volume = generate("neurites", {64, 48, 40}, {{"calibre", 12}, {"ids", 7}});
  std::set<std::uint64_t> labels;
  for (const auto& [label, shape] : shapes_of(volume)) labels.insert(label);
  labels.insert(0);
  EXPECT_THAT(labels, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
}

TEST(Atlas, HasItsRegionsOfVeryDifferentSizesAtAnySize) {
  const Volume volume = generate("atlas", {157, 408, 223});
  EXPECT_EQ(volume.info().type, VoxelType::kU8);
  auto shapes = shapes_of(volume);
  EXPECT_EQ(shapes.size(), 204u);
  EXPECT_EQ(shapes.rbegin()->first, 203u);
  const double background = share(shapes[0].voxels, volume.extent().voxels());
  EXPECT_GT(background, 0.7);
  EXPECT_LT(background, 0.93);
  shapes.erase(0);
  std::vector<std::uint64_t> sizes;
  for (const auto& [label, shape] : shapes) sizes.push_back(shape.voxels);
  std::sort(sizes.begin(), sizes.end());
  EXPECT_GT(sizes.back(), 100 * sizes[sizes.size() / 4]);
}

TEST(Atlas, IsNearlySymmetricAboutTheMiddle) {
  const auto alike = [](double asymmetry) {
    const Volume volume = generate("atlas", {121, 306, 168}, {{"asymmetry", asymmetry}});
    const Extent& e = volume.extent();
    std::uint64_t brain = 0, same = 0;
    for (std::uint64_t i = 0; i < e.voxels(); ++i) {
      const Coordinate c = e.coordinate(i);
      if (volume.label(c) == 0) continue;
      ++brain;
      same += volume.label(c) == volume.label({e.x - 1 - c.x, c.y, c.z}) ? 1 : 0;
    }
    return share(same, brain);
  };
  EXPECT_GT(alike(0.1), 0.85);
  EXPECT_LT(alike(1), 0.8);
}

std::vector<std::uint64_t> worst(double pattern, double bits = 32) {
  const Volume volume = generate("worst-case", {31, 17, 13},
                                 {{"pattern", pattern}, {"bits", bits}, {"density", 0.2}});
  std::vector<std::uint64_t> labels;
  const Extent& e = volume.extent();
  for (std::uint64_t i = 0; i < e.voxels(); ++i) labels.push_back(volume.label(e.coordinate(i)));
  return labels;
}

TEST(WorstCase, PatternsAreWhatTheySay) {
  constexpr std::uint64_t kLargest = 0xFFFFFFFFu;
  constexpr std::size_t kVoxels = 31 * 17 * 13;
  const auto distinct = [](const std::vector<std::uint64_t>& labels) {
    return std::set<std::uint64_t>(labels.begin(), labels.end());
  };

  const auto checkerboard = worst(0);
  EXPECT_THAT(distinct(checkerboard), testing::ElementsAre(0, kLargest));
  EXPECT_NE(checkerboard[0], checkerboard[1]);
  EXPECT_NE(checkerboard[0], checkerboard[31]);
  EXPECT_NE(checkerboard[0], checkerboard[31 * 17]);

  const auto all = distinct(worst(1));
  EXPECT_EQ(all.size(), kVoxels);
  EXPECT_EQ(*all.begin(), 0u);
  EXPECT_EQ(*all.rbegin(), kLargest);

  const auto sheets = worst(2);
  EXPECT_EQ(distinct(sheets).size(), 31u + 17u + 13u - 2u);
  EXPECT_EQ(sheets[1], sheets[31]);
  EXPECT_EQ(sheets[1], sheets[31 * 17]);

  const auto salt = worst(3);
  const auto grains =
      kVoxels - static_cast<std::size_t>(std::count(salt.begin(), salt.end(), kLargest));
  EXPECT_NEAR(share(grains, kVoxels), 0.2, 0.03);
  EXPECT_GT(distinct(salt).size(), grains * 9 / 10);

  EXPECT_THAT(distinct(worst(4)), testing::ElementsAre(kLargest));

  const auto noise = worst(5);
  EXPECT_THAT(distinct(noise), testing::ElementsAre(0, kLargest));
  EXPECT_NEAR(share(static_cast<std::size_t>(std::count(noise.begin(), noise.end(), 0u)), kVoxels),
              0.5, 0.03);
}

TEST(WorstCase, EveryWidthOfVoxels) {
  EXPECT_THAT(worst(0, 8), testing::Contains(0xFFu));
  EXPECT_THAT(worst(0, 16), testing::Contains(0xFFFFu));
  EXPECT_THAT(worst(0, 64), testing::Contains(~std::uint64_t{0}));
  EXPECT_THAT(worst(1, 64), testing::Contains(testing::Gt(std::uint64_t{1} << 40)));
}

}  // namespace
}  // namespace cvr::volumes
