// Writing Neuroglancer precomputed: types, the text of info, offsets, and what is never replaced.
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/unit/volumes/io/precomputed_fixture.hpp"

namespace cvr::volumes {
namespace {

TEST_F(Precomputed, RoundTripWidensSmallLabels) {
  struct Case {
    VoxelType type, stored;
    VolumeKind kind;
  };
  for (const Case& c : {Case{VoxelType::kU8, VoxelType::kU32, VolumeKind::kLabels},
                        Case{VoxelType::kU16, VoxelType::kU32, VolumeKind::kLabels},
                        Case{VoxelType::kU32, VoxelType::kU32, VolumeKind::kLabels},
                        Case{VoxelType::kU64, VoxelType::kU64, VolumeKind::kLabels},
                        Case{VoxelType::kU8, VoxelType::kU8, VolumeKind::kScalars},
                        Case{VoxelType::kU16, VoxelType::kU16, VolumeKind::kScalars},
                        Case{VoxelType::kI16, VoxelType::kI16, VolumeKind::kScalars},
                        Case{VoxelType::kF32, VoxelType::kF32, VolumeKind::kScalars}}) {
    for (const Extent& extent : {Extent{70, 13, 67}, Extent{1, 1, 1}, Extent{65, 66, 3}}) {
      const Volume volume = patterned(extent, c.type, c.kind);
      write_volume(path("a.precomputed"), MemorySource(volume));
      const auto source = open_volume(path("a.precomputed/8_4.5_40"));
      EXPECT_EQ(source->info().extent, extent);
      EXPECT_EQ(source->info().kind, c.kind);
      EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{8, 4.5, 40}));
      ASSERT_EQ(source->info().type, c.stored);
      if (c.type == c.stored) {
        expect_boxes(*source, volume);
        continue;
      }
      Volume widened({.extent = extent, .type = c.stored, .voxel_unit = {}});
      for (std::uint64_t i = 0; i < extent.voxels(); ++i) {
        const Coordinate at = extent.coordinate(i);
        widened.voxels<std::uint32_t>()[i] = static_cast<std::uint32_t>(volume.label(at));
      }
      expect_boxes(*source, widened);
    }
  }
}

TEST_F(Precomputed, WritesTheInfoThatNeuroglancerReads) {
  Volume volume = patterned({70, 13, 67}, VoxelType::kU16, VolumeKind::kLabels);
  volume.info().voxel_unit = "um";
  write_volume(path("new") + "/", MemorySource(volume));
  const auto info = nlohmann::json::parse(read_bytes(path("new/info")));
  EXPECT_EQ(info, nlohmann::json::parse(
                      R"({"@type": "neuroglancer_multiscale_volume", "type": "segmentation",
      "data_type": "uint32", "num_channels": 1, "scales": [{"key": "8000_4500_40000", "size": [70, 13, 67],
      "resolution": [8000.0, 4500.0, 40000.0], "voxel_offset": [0, 0, 0], "chunk_sizes": [[64, 64, 64]],
      "encoding": "compressed_segmentation", "compressed_segmentation_block_size": [8, 8, 8]}]})"));
  for (const char* chunk :
       {"0-64_0-13_0-64", "64-70_0-13_0-64", "0-64_0-13_64-67", "64-70_0-13_64-67"}) {
    const std::string bytes = read_bytes(path("new/8000_4500_40000/") + chunk);
    ASSERT_GE(bytes.size(), 4u);
    EXPECT_EQ(bytes.substr(0, 4), std::string("\1\0\0\0", 4)) << chunk;
  }
}

TEST_F(Precomputed, ReplacesOnlyPrecomputedVolumes) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU32, VolumeKind::kLabels);
  std::filesystem::create_directory(path("empty"));
  write_volume(path("empty/"), MemorySource(volume));
  write_volume(path("empty/"), MemorySource(volume));
  write_bytes("empty/notes.txt", "mine");
  EXPECT_THROW(write_volume(path("empty/"), MemorySource(volume)), OutputError);
  write_bytes("home/thesis.tex", "mine");
  EXPECT_THROW(write_volume(path("home/"), MemorySource(volume)), OutputError);
  EXPECT_EQ(read_bytes(path("home/thesis.tex")), "mine");
  expect_files({"empty", "home"});
}

TEST_F(Precomputed, TheOffsetIsReadAndWritten) {
  const auto source = open_volume(make_small());
  EXPECT_EQ(source->info().offset, (std::array<double, 3>{80, -32, 4000}));
  EXPECT_EQ(source->files(),
            (std::vector<std::string>{std::filesystem::canonical(path("vol")).string()}));
  write_volume(path("copy/"), *source);
  const auto info = nlohmann::json::parse(read_bytes(path("copy/info")));
  EXPECT_EQ(info["scales"][0]["voxel_offset"], nlohmann::json({10, -4, 100}));
  EXPECT_TRUE(std::filesystem::exists(path("copy/8_8_40/10-13_-4--2_100-103")));
  expect_small(*open_volume(path("copy")));
  EXPECT_EQ(open_volume(path("copy"))->info().offset, source->info().offset);
}

TEST_F(Precomputed, AnOffsetBetweenVoxelsIsRefused) {
  Volume volume = patterned({5, 7, 3}, VoxelType::kU32, VolumeKind::kLabels);
  const auto refuse = [&](const std::array<double, 3>& offset, const std::string& text) {
    volume.info().offset = offset;
    try {
      write_volume(path("a/"), MemorySource(volume));
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  };
  refuse({0, 2, 0}, "offset along y: expected a whole number of voxels");
  refuse({0, 0, 40.001}, "offset along z");
  refuse({1e300, 0, 0}, "offset along x");
  refuse({-std::numeric_limits<double>::infinity(), 0, 0}, "offset along x");
  expect_files({});
  volume.info().offset = {8e6 * (1 + 1e-9), -4.5, 0};
  write_volume(path("a/"), MemorySource(volume));
  EXPECT_EQ(open_volume(path("a"))->info().offset, (std::array<double, 3>{8e6, -4.5, 0}));
}

TEST_F(Precomputed, ReplacesNothingThatWasNotWrittenHere) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU32, VolumeKind::kLabels);
  write_volume(path("ours/"), MemorySource(volume));
  const std::string chunk = "ours/8_4.5_40/0-5_0-7_0-3";
  const std::string good = read_bytes(path(chunk));
  for (const char* stranger :
       {"ours/8_4.5_40/notes.txt", "ours/8_4.5_40/0-5_0-7_0-3.gz", "ours/8_4.5_40/0-5_0-7_0-2",
        "ours/8_4.5_40/.hidden", "ours/mesh/1:0", "ours/provenance"}) {
    write_bytes(stranger, "mine");
    EXPECT_THROW(write_volume(path("ours/"), MemorySource(volume)), OutputError) << stranger;
    EXPECT_EQ(read_bytes(path(stranger)), "mine");
    std::filesystem::remove(path(stranger));
    std::filesystem::remove(path("ours/mesh"));
  }
  // A volume of another program: the same kind of folder, another text of info.
  const std::string info = read_bytes(path("ours/info"));
  write_bytes("ours/info", nlohmann::json::parse(info).dump());
  EXPECT_THROW(write_volume(path("ours/"), MemorySource(volume)), OutputError);
  write_bytes("ours/info", info);
  const std::string name = make_small();
  EXPECT_THROW(write_volume(name + "/", MemorySource(volume)), OutputError);
  expect_small(*open_volume(name));
  std::filesystem::create_directory_symlink("ours", path("link"));
  const Volume other = patterned({70, 7, 3}, VoxelType::kU64, VolumeKind::kLabels);
  write_volume(path("link/"), MemorySource(other));
  EXPECT_TRUE(std::filesystem::is_symlink(path("link")));
  expect_boxes(*open_volume(path("ours")), other);
  expect_files({"ours", "vol", "link"});
}

}  // namespace
}  // namespace cvr::volumes
