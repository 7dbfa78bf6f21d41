// Errors with known values: PSNR, edges, relative errors, and voxels that are no numbers.
#include "volumes/metrics/error_sink.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cvr::volumes {
namespace {

template <class T>
Volume scalars(const Extent& extent, VoxelType type,
               T (*value)(std::uint64_t x, std::uint64_t y, std::uint64_t z)) {
  Volume volume({.extent = extent, .type = type, .kind = VolumeKind::kScalars, .voxel_unit = {}});
  for (std::uint64_t i = 0; i < extent.voxels(); ++i)
    volume.voxels<T>()[i] = value(i % extent.x, i / extent.x % extent.y, i / (extent.x * extent.y));
  return volume;
}

/// Feeds `decoded` to the sink in slabs of `depth` planes.
void feed(ErrorSink& sink, const Volume& decoded, std::uint64_t depth) {
  const Extent& e = decoded.extent();
  for (std::uint64_t z = 0; z < e.z; z += depth) {
    const std::uint64_t end = std::min(e.z, z + depth);
    MemorySource(decoded).read({{0, 0, z}, {e.x, e.y, end - z}}, sink.begin(z, end));
    sink.end(z, end);
  }
}

/// A step of 100 between x = 9 and x = 10 of 20 x 10 x 10: the edges are the voxels beside it, 10 %
/// of the volume and all alike.
std::uint8_t step(std::uint64_t x, std::uint64_t, std::uint64_t) { return x < 10 ? 50 : 150; }

TEST(ErrorSink, EqualVolumesAreExactAndHaveNoPsnr) {
  const Volume volume = scalars<std::uint8_t>({20, 10, 10}, VoxelType::kU8, step);
  const MemorySource truth(volume);
  ErrorSink sink(truth);
  feed(sink, volume, 4);
  EXPECT_EQ(sink.mismatches(), 0u);
  EXPECT_FALSE(sink.psnr());
  EXPECT_FALSE(sink.edge_psnr());
  EXPECT_EQ(sink.mean_squared_error(), 0);
  EXPECT_EQ(sink.edge_mean_squared_error(), 0);
  EXPECT_EQ(sink.edge_voxels(), 200u);
  EXPECT_FALSE(sink.relative_error(0.5));
}

TEST(ErrorSink, KnownErrorsForAnySlabsAndThreads) {
  const Volume volume = scalars<std::uint8_t>({20, 10, 10}, VoxelType::kU8, step);
  Volume decoded = volume;
  decoded.voxels<std::uint8_t>()[volume.extent().index({9, 3, 4})] += 10;  // an edge
  decoded.voxels<std::uint8_t>()[volume.extent().index({0, 0, 9})] -= 30;  // none
  const MemorySource truth(volume);
  for (const auto& [threads, depth] : {std::pair{1u, 10u}, {3u, 1u}, {2u, 7u}}) {
    ErrorSink sink(truth, threads);
    feed(sink, decoded, depth);
    EXPECT_EQ(sink.compared(), 2000u);
    EXPECT_EQ(sink.mismatches(), 2u);
    EXPECT_EQ(sink.largest_error(), 30);
    EXPECT_EQ(sink.mean_squared_error(), 1000.0 / 2000);
    EXPECT_EQ(sink.mean_absolute_error(), 40.0 / 2000);
    EXPECT_EQ(sink.edge_voxels(), 200u);
    EXPECT_EQ(sink.edge_mean_squared_error(), 100.0 / 200);
    EXPECT_NEAR(sink.psnr().value(), 10 * std::log10(255.0 * 255 / 0.5), 1e-12);
    EXPECT_EQ(sink.edge_psnr(), sink.psnr());
  }
}

TEST(ErrorSink, TellsTheWorstTimeStep) {
  Volume volume = scalars<std::uint8_t>(
      {8, 6, 12}, VoxelType::kU8, [](std::uint64_t x, std::uint64_t, std::uint64_t z) {
        return static_cast<std::uint8_t>(x < 4 ? 10 + 60 * (z / 3) : 20 + 60 * (z / 3));
      });
  volume.info().time_steps = 4;
  Volume decoded = volume;
  decoded.voxels<std::uint8_t>()[volume.extent().index({1, 1, 1})] += 4;
  decoded.voxels<std::uint8_t>()[volume.extent().index({1, 1, 6})] += 12;
  const MemorySource truth(volume);
  for (const auto& [threads, depth] : {std::pair{1u, 12u}, {3u, 1u}, {2u, 5u}}) {
    ErrorSink sink(truth, threads);
    feed(sink, decoded, depth);
    EXPECT_EQ(sink.time_steps(), 4u);
    EXPECT_EQ(sink.worst_step(), 2u);
    EXPECT_NEAR(sink.worst_step_psnr().value(), 10 * std::log10(255.0 * 255 * 144 / 144.0), 1e-9);
    EXPECT_NEAR(sink.psnr().value(), 10 * std::log10(255.0 * 255 * 576 / 160.0), 1e-9);
    // The jump of 60 between steps is no edge: the voxels beside x = 3 to 4 are.
    EXPECT_EQ(sink.edge_voxels(), 2u * 6 * 12);
  }
  ErrorSink exact(truth);
  feed(exact, volume, 4);
  EXPECT_FALSE(exact.worst_step_psnr());
  volume.info().time_steps = 1;
  const MemorySource one_step(volume);
  ErrorSink single(one_step);
  feed(single, decoded, 4);
  EXPECT_EQ(single.time_steps(), 1u);
}

TEST(ErrorSink, EdgesAreTheSteepestFiveInAHundred) {
  // The gradient along x is 2x but at the sides: 1 at x = 0 and 2x - 1 at the last.
  const Volume volume = scalars<std::uint16_t>({100, 4, 3}, VoxelType::kU16,
                                               [](std::uint64_t x, std::uint64_t, std::uint64_t) {
                                                 return static_cast<std::uint16_t>(x * x);
                                               });
  const MemorySource truth(volume);
  EdgeVoxels edges(truth, 2);
  EXPECT_NEAR(std::sqrt(edges.threshold()), 2 * 95,
              0.2);  // x = 95 .. 99, of which the last has 197
  std::vector<std::uint8_t> marks(400);
  edges.load(1, 2);
  edges.mark(1, marks.data());
  for (std::uint64_t x = 0; x < 100; ++x) EXPECT_EQ(marks[x + 200], x >= 95 ? 1 : 0) << x;
}

TEST(ErrorSink, ConstantVolumesHaveNoEdges) {
  const Volume volume = scalars<std::uint8_t>(
      {5, 1, 6}, VoxelType::kU8,
      [](std::uint64_t, std::uint64_t, std::uint64_t) { return std::uint8_t{7}; });
  Volume decoded = volume;
  decoded.voxels<std::uint8_t>()[0] = 8;
  const MemorySource truth(volume);
  ErrorSink sink(truth);
  feed(sink, decoded, 6);
  EXPECT_EQ(sink.edge_voxels(), 0u);
  EXPECT_FALSE(sink.edge_mean_squared_error());
  EXPECT_TRUE(sink.psnr());  // the peak of u8 is 255 whatever the range
}

TEST(ErrorSink, NonFiniteVoxelsOfTheOriginalAreCountedAndLeftOut) {
  Volume volume = scalars<float>(
      {4, 4, 4}, VoxelType::kF32,
      [](std::uint64_t x, std::uint64_t, std::uint64_t) { return static_cast<float>(x); });
  volume.voxels<float>()[5] = std::numeric_limits<float>::quiet_NaN();
  volume.voxels<float>()[63] = -std::numeric_limits<float>::infinity();
  Volume decoded = volume;
  decoded.voxels<float>()[5] = 1e20F;
  decoded.voxels<float>()[10] += 0.5F;
  const MemorySource truth(volume);
  ErrorSink sink(truth);
  feed(sink, decoded, 2);
  EXPECT_EQ(sink.non_finite(), 2u);
  EXPECT_EQ(sink.mismatches(), 2u);
  EXPECT_EQ(sink.largest_error(), 0.5);
  EXPECT_EQ(sink.mean_squared_error(), 0.25 / 62);
  EXPECT_NEAR(sink.psnr().value(), 10 * std::log10(9 / (0.25 / 62)),
              1e-12);  // the range is that of the finite voxels
}

TEST(ErrorSink, DecodedVoxelsThatAreNoNumbersAreInfinitelyWrong) {
  const Volume volume = scalars<float>(
      {3, 2, 2}, VoxelType::kF32,
      [](std::uint64_t x, std::uint64_t, std::uint64_t) { return static_cast<float>(x); });
  Volume decoded = volume;
  decoded.voxels<float>()[4] = std::numeric_limits<float>::quiet_NaN();
  const MemorySource truth(volume);
  ErrorSink sink(truth);
  feed(sink, decoded, 2);
  EXPECT_TRUE(std::isinf(sink.largest_error()));
  EXPECT_FALSE(sink.psnr());
  EXPECT_EQ(sink.mismatches(), 1u);
}

TEST(ErrorSink, RelativeErrorsOfFloats) {
  // 100 voxels 1e-20, 1e-19, ... and one that rules the range; the k-th is wrong by k %.
  Volume volume = scalars<float>(
      {100, 1, 1}, VoxelType::kF32, [](std::uint64_t x, std::uint64_t, std::uint64_t) {
        return static_cast<float>(std::pow(10.0, static_cast<double>(x % 40) - 20));
      });
  Volume decoded = volume;
  for (std::uint64_t x = 0; x < 100; ++x)
    decoded.voxels<float>()[x] *= 1 + static_cast<float>(x + 1) / 100;
  const MemorySource truth(volume);
  ErrorSink sink(truth, 2);
  feed(sink, decoded, 1);
  EXPECT_NEAR(sink.relative_error(0.5).value(), 0.50, 0.001);
  EXPECT_NEAR(sink.relative_error(0.9).value(), 0.90, 0.001);
  EXPECT_NEAR(sink.relative_error(0.99).value(), 0.99, 0.001);
}

}  // namespace
}  // namespace cvr::volumes
