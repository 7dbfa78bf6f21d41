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
Row errors_of(const volumes::Volume& truth, const volumes::Volume& decoded) {
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
  const Row row = errors_of(volume, volume);
  EXPECT_TRUE(row["exact"].get<bool>());
  EXPECT_TRUE(row["psnr_db"].is_null());
  EXPECT_TRUE(row["edge_psnr_db"].is_null());
  EXPECT_EQ(row["mean_squared_error"], 0);
  EXPECT_FALSE(row.contains("relative_error"));
  EXPECT_FALSE(row.contains("time_steps"));
}

TEST(ErrorRow, SeriesAndFloatsTellMore) {
  const auto truth = ramp(VoxelType::kF32, 2);
  auto decoded = truth;
  decoded.voxels<float>()[100] += 1;
  const Row row = errors_of(truth, decoded);
  EXPECT_FALSE(row["exact"].get<bool>());
  EXPECT_EQ(row["time_steps"], 2);
  EXPECT_EQ(row["worst_step"], 1);
  EXPECT_TRUE(row["worst_step_psnr_db"].is_number());
  EXPECT_TRUE(row["relative_error"]["p99"].is_number());
}

TEST(ErrorRow, InfinityIsNull) {
  const auto truth = ramp(VoxelType::kF32);
  auto decoded = truth;
  decoded.voxels<float>()[3] = std::numeric_limits<float>::quiet_NaN();
  const Row row = errors_of(truth, decoded);
  EXPECT_TRUE(row["largest_error"].is_null());
  EXPECT_TRUE(row["psnr_db"].is_null());
  EXPECT_FALSE(row["exact"].get<bool>());
}

}  // namespace
}  // namespace cvr::experiments
