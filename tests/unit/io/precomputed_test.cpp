// Neuroglancer precomputed: chunks made by hand with an offset and partial borders, gzip, missing chunks, and
// the writer.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "io_fixture.hpp"
#include "volumes/io/gzip.hpp"

namespace cvr::volumes {
namespace {

class Precomputed : public IoTest {
 protected:
  static nlohmann::json small_info() {
    return nlohmann::json::parse(R"({"type": "image", "data_type": "uint8", "num_channels": 1, "scales": [
      {"key": "8_8_40", "size": [3, 2, 3], "resolution": [8, 8, 40], "voxel_offset": [10, -4, 100],
       "chunk_sizes": [[2, 2, 2]], "encoding": "raw"},
      {"key": "16_16_40", "size": [2, 1, 2], "resolution": [16, 16, 40], "chunk_sizes": [[2, 2, 2]], "encoding": "raw"}]})");
  }

  /// A volume of 3 x 2 x 3 whose voxel (x, y, z) is 100 + x + 10 y + 20 z, in chunks of 2.
  std::string make_small() const {
    write_bytes("vol/info", small_info().dump());
    for (int z = 0; z < 3; z += 2) {
      for (int x = 0; x < 3; x += 2) {
        std::string bytes;
        for (int k = z; k < std::min(z + 2, 3); ++k) {
          for (int j = 0; j < 2; ++j) {
            for (int i = x; i < std::min(x + 2, 3); ++i)
              bytes += static_cast<char>(100 + i + 10 * j + 20 * k);
          }
        }
        write_bytes(fmt::format("vol/8_8_40/{}-{}_-4--2_{}-{}", 10 + x, 10 + std::min(x + 2, 3), 100 + z,
                                100 + std::min(z + 2, 3)),
                    bytes);
      }
    }
    return path("vol");
  }

  void expect_small(const VolumeSource& source) const {
    EXPECT_EQ(source.info().extent, (Extent{3, 2, 3}));
    const Volume volume = read_all(source);
    for (std::uint64_t z = 0; z < 3; ++z) {
      for (std::uint64_t y = 0; y < 2; ++y) {
        for (std::uint64_t x = 0; x < 3; ++x) EXPECT_EQ(volume.label({x, y, z}), 100 + x + 10 * y + 20 * z);
      }
    }
    expect_boxes(source, volume);
  }

  static std::string gzipped(const std::string& bytes) {
    std::string stream;
    GzipWriter gzip(
        [&](std::span<const std::byte> part) {
          stream.append(reinterpret_cast<const char*>(part.data()), part.size());
        },
        6);
    gzip.write(std::as_bytes(std::span(bytes)));
    gzip.finish();
    return stream;
  }
};

TEST_F(Precomputed, ChunksWithOffsetAndPartialBorders) {
  const std::string name = make_small();
  for (const std::string& spelled : {name, name + "/", name + "/8_8_40", name + "/8_8_40/"}) {
    EXPECT_TRUE(is_volume_path(spelled));
    const auto source = open_volume(spelled);
    EXPECT_EQ(source->info().kind, VolumeKind::kScalars);
    EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{8, 8, 40}));
    EXPECT_EQ(source->info().voxel_unit, "nm");
    expect_small(*source);
  }
}

TEST_F(Precomputed, GzippedChunksByMagicAndByName) {
  const std::string name = make_small();
  const std::string first = name + "/8_8_40/10-12_-4--2_100-102";
  const std::string second = name + "/8_8_40/12-13_-4--2_100-102";
  write_bytes("vol/8_8_40/10-12_-4--2_100-102", gzipped(read_bytes(first)));
  write_bytes("vol/8_8_40/12-13_-4--2_100-102.gz", gzipped(read_bytes(second)));
  std::filesystem::remove(second);
  expect_small(*open_volume(name));
}

TEST_F(Precomputed, PlainVoxelsMayBeginLikeGzip) {
  const std::string name = make_small();
  write_bytes("vol/8_8_40/10-12_-4--2_100-102", std::string_view("\x1f\x8b\x08\x00ghij", 8));
  const Volume volume = read_all(*open_volume(name));
  EXPECT_EQ(volume.label({0, 0, 0}), 0x1fu);
  EXPECT_EQ(volume.label({1, 0, 0}), 0x8bu);
  EXPECT_EQ(volume.label({0, 1, 0}), 8u);
  EXPECT_EQ(volume.label({1, 1, 1}), std::uint64_t{'j'});
}

TEST_F(Precomputed, MissingChunksAreZeroButMissingScalesAreErrors) {
  const std::string name = make_small();
  std::filesystem::remove(name + "/8_8_40/12-13_-4--2_100-102");
  const auto source = open_volume(name);
  const Volume volume = read_all(*source);
  EXPECT_EQ(volume.label({2, 0, 0}), 0u);
  EXPECT_EQ(volume.label({2, 1, 1}), 0u);
  EXPECT_EQ(volume.label({1, 1, 1}), 131u);
  EXPECT_EQ(volume.label({2, 0, 2}), 142u);
  expect_boxes(*source, volume);
  expect_error(name + "/16_16_40", {"16_16_40"});
  expect_error(name + "/4_4_40/", {"'4_4_40'", "8_8_40, 16_16_40"});
}

TEST_F(Precomputed, CompressedSegmentationByHand) {
  // One block of 2 x 2 x 1 of which 2 x 1 x 1 are inside: labels 7 and 2^33 + 5, one bit each.
  write_bytes("vol/info", R"({"type": "segmentation", "data_type": "uint64", "num_channels": 1, "scales": [
      {"key": "s", "size": [2, 1, 1], "resolution": [4, 4, 4], "voxel_offset": [0, 0, 0], "chunk_sizes": [[64, 64, 64]],
       "encoding": "compressed_segmentation", "compressed_segmentation_block_size": [2, 2, 1]}]})");
  const std::array<std::uint32_t, 8> words{1, 3u | (1u << 24), 2, 0b10, 7, 0, 5, 2};
  const std::string stream(reinterpret_cast<const char*>(words.data()), sizeof words);
  for (const std::string& chunk : {stream, gzipped(stream)}) {
    write_bytes("vol/s/0-2_0-1_0-1", chunk);
    const auto source = open_volume(path("vol"));
    EXPECT_EQ(source->info().kind, VolumeKind::kLabels);
    const Volume volume = read_all(*source);
    EXPECT_EQ(volume.label({0, 0, 0}), 7u);
    EXPECT_EQ(volume.label({1, 0, 0}), (std::uint64_t{1} << 33) + 5);
  }
  for (std::size_t length = 0; length < stream.size(); ++length) {
    write_bytes("vol/s/0-2_0-1_0-1", stream.substr(0, length));
    expect_error(path("vol"), {"0-2_0-1_0-1"});
  }
}

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
        const Coordinate at{i % extent.x, i / extent.x % extent.y, i / (extent.x * extent.y)};
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
  EXPECT_EQ(info, nlohmann::json::parse(R"({"@type": "neuroglancer_multiscale_volume", "type": "segmentation",
      "data_type": "uint32", "num_channels": 1, "scales": [{"key": "8000_4500_40000", "size": [70, 13, 67],
      "resolution": [8000.0, 4500.0, 40000.0], "voxel_offset": [0, 0, 0], "chunk_sizes": [[64, 64, 64]],
      "encoding": "compressed_segmentation", "compressed_segmentation_block_size": [8, 8, 8]}]})"));
  for (const char* chunk : {"0-64_0-13_0-64", "64-70_0-13_0-64", "0-64_0-13_64-67", "64-70_0-13_64-67"}) {
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
  EXPECT_THROW(write_volume(path("empty/"), MemorySource(volume)), InputError);
  write_bytes("home/thesis.tex", "mine");
  EXPECT_THROW(write_volume(path("home/"), MemorySource(volume)), InputError);
  EXPECT_EQ(read_bytes(path("home/thesis.tex")), "mine");
  expect_files({"empty", "home"});
}

TEST_F(Precomputed, RefusesWhatItCannotRead) {
  const auto refuse = [this](const char* pointer, const nlohmann::json& value,
                             const std::vector<std::string>& parts) {
    nlohmann::json info = small_info();
    info[nlohmann::json::json_pointer(pointer)] = value;
    write_bytes("vol/info", info.dump());
    expect_error(path("vol"), parts);
  };
  make_small();
  refuse("/type", "mesh", {"info: type", "mesh"});
  refuse("/data_type", "float64", {"data_type", "float64"});
  refuse("/data_type", 8, {"data_type", "8"});
  refuse("/data_type", "uint32", {"u32"});
  refuse("/num_channels", 3, {"num_channels", "3"});
  refuse("/scales", nlohmann::json::array(), {"scales", "[]"});
  refuse("/scales/0/size", {3, 2}, {"scales[0].size", "[3,2]"});
  refuse("/scales/0/size", {3, 2, -3}, {"scales[0].size[2]", "-3"});
  refuse("/scales/0/size", {3, 2, 0}, {"scales[0].size[2]", "0"});
  refuse("/scales/0/size", {1 << 20, 1 << 20, 1 << 20}, {"2^48"});
  refuse("/scales/0/resolution", {8, 8, 0}, {"resolution[2]", "0"});
  refuse("/scales/0/voxel_offset", {0.5, 0, 0}, {"voxel_offset[0]", "0.5"});
  refuse("/scales/0/chunk_sizes", nlohmann::json::array(), {"chunk_sizes", "[]"});
  refuse("/scales/0/encoding", "jpeg", {"encoding", "jpeg"});
  refuse("/scales/0/encoding", "compressed_segmentation", {"uint32 or uint64"});
  refuse("/scales/0/sharding", {{"@type", "neuroglancer_uint64_sharded_v1"}}, {"sharding", "unsharded"});
  refuse("/scales/0/key", "../8_8_40", {"key", "../8_8_40"});
  refuse("/scales/0/key", "", {"key"});
  for (const char* text : {"", "{", "[]", "7", "{\"type\": \"image\"}"}) {
    write_bytes("vol/info", text);
    expect_error(path("vol"), {"info"});
  }
}

TEST_F(Precomputed, DamagedChunksAreErrors) {
  const std::string name = make_small();
  const std::string chunk = name + "/8_8_40/10-12_-4--2_100-102";
  const std::string good = read_bytes(chunk);
  write_bytes("vol/8_8_40/10-12_-4--2_100-102", good.substr(1));
  expect_error(name, {"10-12_-4--2_100-102", "8 bytes", "7"});
  write_bytes("vol/8_8_40/10-12_-4--2_100-102", gzipped(good + "more"));
  expect_error(name, {"at most 8"});
  write_bytes("vol/8_8_40/10-12_-4--2_100-102", gzipped(good).substr(0, 20));
  expect_error(name, {"10-12_-4--2_100-102"});
}

}  // namespace
}  // namespace cvr::volumes
