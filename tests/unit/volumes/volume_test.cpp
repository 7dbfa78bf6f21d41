#include "volumes/volume.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "volumes/source.hpp"

namespace cvr::volumes {
namespace {

Volume counting_volume(const Extent& extent) {
  Volume volume({.extent = extent, .type = VoxelType::kU32, .voxel_unit = {}});
  std::uint32_t n = 0;
  for (std::uint32_t& voxel : volume.voxels<std::uint32_t>()) voxel = n++;
  return volume;
}

TEST(Volume, IndexRunsXFastest) {
  const Volume volume = counting_volume({3, 5, 7});
  EXPECT_EQ(volume.label({2, 0, 0}), 2u);
  EXPECT_EQ(volume.label({0, 1, 0}), 3u);
  EXPECT_EQ(volume.label({0, 0, 1}), 15u);
}

TEST(Volume, TypeNamesRoundTrip) {
  for (const VoxelType type : kVoxelTypes) EXPECT_EQ(voxel_type_from_name(name_of(type)), type);
  EXPECT_FALSE(voxel_type_from_name("u128").has_value());
}

TEST(MemorySource, ReadsBoxes) {
  const Volume volume = counting_volume({3, 5, 7});
  std::vector<std::uint32_t> box(2 * 2 * 2);
  MemorySource(volume).read({{1, 2, 3}, {2, 2, 2}}, reinterpret_cast<std::byte*>(box.data()));
  EXPECT_EQ(box, (std::vector<std::uint32_t>{52, 53, 55, 56, 67, 68, 70, 71}));
}

TEST(CompareSink, CountsMismatches) {
  const Volume volume = counting_volume({3, 5, 7});
  const MemorySource source(volume);
  CompareSink sink(source);
  std::byte* out = sink.begin(0, 7);
  std::memcpy(out, volume.data(), volume.info().bytes());
  out[4] ^= std::byte{1};
  out[400] ^= std::byte{1};
  sink.end(0, 7);
  EXPECT_EQ(sink.compared(), 105u);
  EXPECT_EQ(sink.mismatches(), 2u);
}

}  // namespace
}  // namespace cvr::volumes
