// The image of hdf5-gzip is an HDF5 file for everybody: libhdf5 reads it from disk.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "codecs/codec.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/small_labels.hpp"
#include "volumes/io/io.hpp"

namespace cvr::codecs {
namespace {

using test::Content;
using test::sample_volume;

const Codec& codec() { return *find_codec("hdf5-gzip"); }
Parameters parameters(const std::vector<std::string>& assignments) {
  return Parameters::parse(codec().parameters(), assignments).value();
}

TEST(Hdf5Image, IsReadByLibhdf5) {
  const auto path = std::filesystem::path(testing::TempDir()) / "cvrbench_peers_image.h5";
  for (const auto& assignments :
       {std::vector<std::string>{}, {"shuffle=1", "chunk=7,5,3"}, {"level=0", "chunk=40,1,1"}}) {
    for (const VoxelType type : volumes::kVoxelTypes) {
      const VoxelType as = type == VoxelType::kI16   ? VoxelType::kU16
                           : type == VoxelType::kF32 ? VoxelType::kU32
                                                     : type;
      Volume volume = sample_volume(Content::kNoise, {41, 23, 17}, as);
      volume.info().type = type;
      if (type != as) volume.info().kind = VolumeKind::kScalars;
      const auto payload =
          codec().encode(volumes::MemorySource(volume), parameters(assignments), 2);
      ASSERT_TRUE(payload) << payload.error().message;
      std::ofstream(path, std::ios::binary)
          .write(reinterpret_cast<const char*>(payload->bytes.data()),
                 static_cast<std::streamsize>(payload->bytes.size()));
      const auto source = volumes::open_volume(path.string());
      EXPECT_EQ(source->info().extent, volume.extent());
      EXPECT_EQ(source->info().type, type);
      const Volume read = volumes::read_all(*source);
      EXPECT_EQ(std::memcmp(read.data(), volume.data(), volume.bytes().size()), 0);
    }
  }
  std::filesystem::remove(path);
}

TEST(Hdf5Image, RefusesChunksOutOfRange) {
  const Volume volume = sample_volume(Content::kZero, {300, 300, 300}, VoxelType::kU8);
  const auto large =
      codec().encode(volumes::MemorySource(volume), parameters({"chunk=300,300,300"}), 1);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code, ErrorCode::kTooLarge);
  const auto mixed = codec().encode(volumes::MemorySource(volume), parameters({"chunk=8,0,8"}), 1);
  ASSERT_FALSE(mixed);
  EXPECT_EQ(mixed.error().code, ErrorCode::kBadArgument);
}

}  // namespace
}  // namespace cvr::codecs
