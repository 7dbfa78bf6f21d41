// Errors as rows hold them: what is no number is null, and fields are there only where they mean
// something.
#include "experiments/results/error_row.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace cvr::experiments {
namespace {

using volumes::VoxelType;

/// The errors of `decoded` against `truth`, whole volumes of scalars.
Parts::Error errors_of(const volumes::Volume& truth, const volumes::Volume& decoded) {
  const volumes::MemorySource source(truth);
  volumes::ErrorSink sink(source);
  std::memcpy(sink.begin(0, truth.extent().z), decoded.data(), truth.info().bytes());
  sink.end(0, truth.extent().z);
  return describe_errors(sink);
}

volumes::Volume ramp(VoxelType type, std::uint64_t steps = 1) {
  volumes::Volume volume({.extent = {6, 5, 4},
                          .type = type,
                          .kind = volumes::VolumeKind::kScalars,
                          .voxel_unit = {},
                          .time_steps = steps});
  for (std::uint64_t i = 0; i < 120; ++i) {
    if (type == VoxelType::kU8)
      volume.voxels<std::uint8_t>()[i] = static_cast<std::uint8_t>(i);
    else
      volume.voxels<float>()[i] = static_cast<float>(i);
  }
  return volume;
}

TEST(ErrorRow, EqualVolumesHaveNoPsnr) {
  const auto volume = ramp(VoxelType::kU8);
  const Parts::Error error = errors_of(volume, volume);
  EXPECT_TRUE(error.exact);
  EXPECT_FALSE(error.psnr_db);
  EXPECT_FALSE(error.edge_psnr_db);
  EXPECT_EQ(error.mean_squared_error.value(), 0);
  EXPECT_FALSE(error.relative_error);
  EXPECT_FALSE(error.time_steps);
}

TEST(ErrorRow, SeriesAndFloatsTellMore) {
  const auto truth = ramp(VoxelType::kF32, 2);
  auto decoded = truth;
  decoded.voxels<float>()[100] += 1;
  const Parts::Error error = errors_of(truth, decoded);
  EXPECT_FALSE(error.exact);
  EXPECT_EQ(error.time_steps, 2u);
  EXPECT_EQ(error.worst_step, 1u);
  EXPECT_TRUE(error.worst_step_psnr_db.value());
  EXPECT_TRUE(*error.relative_error->find("p99"));
}

TEST(ErrorRow, InfinityIsNull) {
  const auto truth = ramp(VoxelType::kF32);
  auto decoded = truth;
  decoded.voxels<float>()[3] = std::numeric_limits<float>::quiet_NaN();
  const Parts::Error error = errors_of(truth, decoded);
  EXPECT_FALSE(error.largest_error);
  EXPECT_FALSE(error.psnr_db);
  EXPECT_FALSE(error.exact);
}

}  // namespace
}  // namespace cvr::experiments
