// The label that a brick is said to have alone is that of every voxel of it, for every codec with
// bricks and every sample volume.
#include <gtest/gtest.h>

#include <cstring>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::codecs {
namespace {

/// How many bricks were told of; every such label is compared with all voxels of its brick.
std::uint64_t check_bricks(const Volume& volume, const BrickAccess& bricks) {
  const Extent& extent = volume.extent();
  const Extent grid = bricks.brick_grid(), size = bricks.brick_size();
  std::uint64_t told = 0;
  for (std::uint64_t i = 0; i < grid.voxels(); ++i) {
    const Coordinate brick = grid.coordinate(i);
    const auto only = bricks.only_label(brick);
    EXPECT_TRUE(only) << only.error().message;
    if (!only || !*only) continue;
    ++told;
    for (std::uint64_t z = brick.z * size.z; z < std::min(extent.z, (brick.z + 1) * size.z); ++z) {
      for (std::uint64_t y = brick.y * size.y; y < std::min(extent.y, (brick.y + 1) * size.y);
           ++y) {
        for (std::uint64_t x = brick.x * size.x; x < std::min(extent.x, (brick.x + 1) * size.x);
             ++x) {
          if (volume.label({x, y, z}) != **only) {
            ADD_FAILURE() << "voxel " << x << " " << y << " " << z;
            return told;
          }
        }
      }
    }
  }
  EXPECT_FALSE(bricks.only_label({grid.x, 0, 0}) && *bricks.only_label({grid.x, 0, 0}))
      << "no brick lies there";
  return told;
}

TEST(OnlyLabel, IsThatOfEveryVoxelOfTheBrick) {
  std::uint64_t told = 0;
  for (const Codec* codec : all_codecs()) {
    if (!codec->traits().lossless) continue;
    const Parameters parameters = Parameters::parse(codec->parameters(), {}).value();
    for (const samples::SampleVolume& sample : samples::sample_volumes()) {
      if (sample.info.kind != VolumeKind::kLabels || !samples::accepts(*codec, sample)) continue;
      SCOPED_TRACE(std::string(codec->traits().id) + " " + sample.name);
      const Volume volume = sample.volume();
      const auto encoded = encode(*codec, volumes::MemorySource(volume), parameters, 1);
      if (!encoded) continue;
      const auto file = open_file(encoded->bytes.bytes());
      ASSERT_TRUE(file) << file.error().message;
      const auto decoder = open_decoder(*file);
      ASSERT_TRUE(decoder) << decoder.error().message;
      if (const BrickAccess* bricks = (*decoder)->brick_access())
        told += check_bricks(volume, *bricks);
    }
  }
  EXPECT_GT(told, 20u) << "samples of one label have such bricks";
}

}  // namespace
}  // namespace cvr::codecs
