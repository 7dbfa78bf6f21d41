// Neuroglancer precomputed: chunks made by hand with an offset and partial borders, gzip, missing chunks,
// what must not pass for zeros, the writer, and folders that other programs wrote.
#include <fmt/format.h>
#include <sys/stat.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
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

  /// Shape, type, voxels and sum as the description of a volume says; its lists are slowest axis first.
  static void expect_volume(const std::string& name, const nlohmann::json& expected) {
    const auto source = open_volume(name);
    const VolumeInfo& info = source->info();
    EXPECT_EQ(expected["shape"], nlohmann::json({info.extent.z, info.extent.y, info.extent.x}));
    EXPECT_EQ(expected["voxel_size"],
              nlohmann::json({info.voxel_size[2], info.voxel_size[1], info.voxel_size[0]}));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(info.offset[axis], expected["voxel_offset"][2 - axis].get<double>() * info.voxel_size[axis]);
    }
    const Volume volume = read_all(*source);
    const auto value = [&](const Coordinate& at) {
      return info.type == VoxelType::kF32 ? volume.voxels<const float>()[info.extent.index(at)]
                                          : double(volume.label(at));
    };
    for (const auto& [index, found] :
         expected["voxels"].get<std::vector<std::pair<std::array<std::uint64_t, 3>, double>>>()) {
      EXPECT_EQ(value({index[2], index[1], index[0]}), found);
    }
    long double sum = 0;
    std::uint64_t nonzero = 0;
    for (std::uint64_t i = 0; i < info.extent.voxels(); ++i) {
      const Coordinate at{i % info.extent.x, i / info.extent.x % info.extent.y,
                          i / (info.extent.x * info.extent.y)};
      sum += info.type == VoxelType::kF32 ? value(at) : static_cast<long double>(volume.label(at));
      nonzero += value(at) != 0;
    }
    EXPECT_EQ(nonzero, expected["nonzero"].get<std::uint64_t>());
    const double total = expected["sum"].get<double>();
    EXPECT_NEAR(static_cast<double>(sum), total, std::fabs(total) * 1e-12);
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
  expect_error(name + "/4_4_40/", {"'4_4_40'", "8_8_40 (3 x 2 x 3 voxels of 8 x 8 x 40 nm)",
                                   "16_16_40 (2 x 1 x 2", "FOLDER/KEY"});
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
  EXPECT_THROW(write_volume(path("empty/"), MemorySource(volume)), OutputError);
  write_bytes("home/thesis.tex", "mine");
  EXPECT_THROW(write_volume(path("home/"), MemorySource(volume)), OutputError);
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
  refuse("/scales/0/size", {3, 2, -3}, {"info: scales", "8_8_40 (3 x 2 x -3 voxels", "FOLDER/KEY"});
  refuse("/scales/0/size", {3, 2, 2.5}, {"scales[0].size[2]", "2.5"});
  refuse("/scales/0/size", {1 << 20, 1 << 20, 1 << 20}, {"2^48"});
  refuse("/scales/0/resolution", {8, 8, 0}, {"resolution[2]", "0"});
  refuse("/scales/0/voxel_offset", {0.5, 0, 0}, {"voxel_offset[0]", "0.5"});
  refuse("/scales/0/chunk_sizes", nlohmann::json::array(), {"chunk_sizes", "[]"});
  refuse("/scales/0/encoding", "jpeg", {"encoding", "jpeg"});
  refuse("/scales/0/encoding", "compressed_segmentation", {"uint32 or uint64", "data_type uint8"});
  refuse("/scales/0/chunk_sizes", {{2, 2, 2}, {1, 2}}, {"chunk_sizes[1]", "[1,2]"});
  refuse("/scales/1/key", "8_8_40", {"scales[1].key", "no other scale"});
  refuse("/@type", "neuroglancer_legacy_mesh", {"@type", "neuroglancer_legacy_mesh"});
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

TEST_F(Precomputed, WhatFitsNothingNeverPassesForZeros) {
  const std::string name = make_small();
  const std::string folder = name + "/8_8_40/";
  for (const char* stranger :
       {"10-12_-4--2_100-102.br", "10-12_-4--2_100-102.zst", "10-12_-4--2_100-102.part0", "0-2_-4--2_100-102",
        "10-13_-4--2_100-102", "12-14_-4--2_100-102", "14-16_-4--2_100-102", "0.shard", "notes.txt",
        "99999999999999999999-1_0-1_0-1"}) {
    write_bytes(std::string("vol/8_8_40/") + stranger, "mine");
    expect_error(name, {stranger, "10-12_-4--2_100-102"});
    std::filesystem::remove(folder + stranger);
  }
  // All files that are there have an ending that is not read.
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::filesystem::rename(entry.path(), entry.path().string() + ".br");
  }
  expect_error(name, {"'.br'", ".gz"});
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  expect_error(name, {"8_8_40", "at least one chunk", "10-12_-4--2_100-102"});
  make_small();
  write_bytes("vol/8_8_40/.DS_Store", "left by a file browser");
  std::filesystem::create_directory(folder + "finer");
  expect_small(*open_volume(name));
  ASSERT_EQ(::mkfifo((folder + "12-13_-4--2_102-103.gz").c_str(), 0600), 0);
  expect_error(name, {"12-13_-4--2_102-103.gz", "pipe"});
}

TEST_F(Precomputed, AnEditedOffsetIsAnError) {
  const std::string name = make_small();
  nlohmann::json info = small_info();
  info["scales"][0]["voxel_offset"] = {11, -4, 100};
  write_bytes("vol/info", info.dump());
  expect_error(name, {"8_8_40", "11-13_-4--2_100-102", "voxel_offset"});
}

TEST_F(Precomputed, PlainAndGzippedFilesOfOneChunkContradict) {
  const std::string name = make_small();
  write_bytes("vol/8_8_40/10-12_-4--2_100-102.gz", gzipped(read_bytes(name + "/8_8_40/10-12_-4--2_100-102")));
  expect_error(name, {"10-12_-4--2_100-102", "one file of a chunk"});
}

TEST_F(Precomputed, ChunksOfSeveralSizesLieInOneFolder) {
  const std::string name = make_small();
  nlohmann::json info = small_info();
  info["scales"][0]["chunk_sizes"] = {{2, 2, 2}, {3, 1, 3}};
  write_bytes("vol/info", info.dump());
  write_bytes("vol/8_8_40/10-13_-4--3_100-103", "123456789");
  expect_small(*open_volume(name));
}

TEST_F(Precomputed, WholeNumbersMayBeWrittenAsFloats) {
  make_small();
  std::string text = small_info().dump();
  for (const auto& [from, to] : {std::pair{"[10,-4,100]", "[10.0,-4.0,1e2]"},
                                 {"[3,2,3]", "[3.0,2.0,3.0]"},
                                 {"[8,8,40]", "[8.0,8.0,40.0]"},
                                 {"[[2,2,2]]", "[[2.0,2.0,2.0]]"}}) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), std::string_view(from).size(), to);
  }
  write_bytes("vol/info", text);
  expect_small(*open_volume(path("vol")));
}

TEST_F(Precomputed, KeysGivenTwiceAndDeepNestingAreErrors) {
  make_small();
  std::string text = small_info().dump();
  write_bytes("vol/info", "{\"data_type\": \"uint16\"," + text.substr(1));
  expect_error(path("vol"), {"data_type", "twice"});
  const std::string size = "\"size\":[3,2,3],";
  text.insert(text.find("\"size\""), size);
  write_bytes("vol/info", text);
  expect_error(path("vol"), {"size", "twice"});
  write_bytes("vol/info", std::string(300000, '['));
  expect_error(path("vol"), {"info", "64 levels"});
}

TEST_F(Precomputed, APlaceholderFirstScaleAsksForAKey) {
  make_small();
  nlohmann::json info = small_info();
  const nlohmann::json placeholder = nlohmann::json::parse(
      R"({"key": "1_1_1", "size": [1, 1, 1], "resolution": [1, 1, 1], "chunk_sizes": [[1, 1, 1]], "encoding": "raw"})");
  info["scales"].insert(info["scales"].begin(), placeholder);
  for (const nlohmann::json& size : {nlohmann::json{1, 1, 1}, nlohmann::json{0, 0, 0}}) {
    info["scales"][0]["size"] = size;
    write_bytes("vol/info", info.dump());
    expect_error(path("vol"),
                 {"scales", "1_1_1 (", "8_8_40 (3 x 2 x 3 voxels of 8 x 8 x 40 nm)", "FOLDER/KEY"});
    expect_small(*open_volume(path("vol/8_8_40")));
  }
  info = small_info();
  info["scales"][0]["key"] = "missing";
  write_bytes("vol/info", info.dump());
  expect_error(path("vol"), {"vol/missing", "16_16_40", "FOLDER/KEY"});
}

TEST_F(Precomputed, AxesAreThoseOfTheFormat) {
  const std::string name = make_small();
  for (const char* axes : {"", "xyz", "xyzc"}) {
    OpenOptions options;
    options.axes = axes;
    expect_small(*open_volume(name, options));
  }
  for (const char* axes : {"zyx", "xy", "txyz", "xyz "}) {
    OpenOptions options;
    options.axes = axes;
    try {
      open_volume(name, options);
      ADD_FAILURE() << axes;
    } catch (const InputError& error) {
      EXPECT_NE(
          std::string(error.what())
              .find(fmt::format("axes: expected none, xyz or xyzc, since precomputed volumes are stored so, "
                                "found '{}'",
                                axes)),
          std::string::npos)
          << error.what();
    }
  }
}

TEST_F(Precomputed, NothingOutsideTheFolderIsReadUnlessAllowed) {
  OpenOptions allowed;
  allowed.allow_external = true;
  const std::string name = make_small();
  const std::string chunk = name + "/8_8_40/10-12_-4--2_100-102";
  std::filesystem::rename(chunk, path("elsewhere"));
  std::filesystem::create_symlink(path("elsewhere"), chunk);
  expect_error(name, {"10-12_-4--2_100-102", path("elsewhere"), "--allow-external"});
  expect_small(*open_volume(name, allowed));
  // A link inside the folder is no way out of it.
  std::filesystem::remove(chunk);
  std::filesystem::rename(path("elsewhere"), name + "/kept");
  std::filesystem::create_symlink("../kept", chunk);
  expect_small(*open_volume(name));
  std::filesystem::rename(name + "/8_8_40", path("scale"));
  std::filesystem::create_directory_symlink(path("scale"), name + "/8_8_40");
  expect_error(name, {"8_8_40", path("scale"), "--allow-external"});
  std::filesystem::remove(path("scale/10-12_-4--2_100-102"));
  std::filesystem::rename(name + "/kept", path("scale/10-12_-4--2_100-102"));
  expect_small(*open_volume(name, allowed));
  std::filesystem::rename(name + "/info", path("info"));
  std::filesystem::create_symlink(path("info"), name + "/info");
  expect_error(name, {"info", path("info"), "--allow-external"});
  std::filesystem::create_directory_symlink("vol", path("link"));
  expect_small(*open_volume(path("link"), allowed));
}

TEST_F(Precomputed, TheOffsetIsReadAndWritten) {
  const auto source = open_volume(make_small());
  EXPECT_EQ(source->info().offset, (std::array<double, 3>{80, -32, 4000}));
  EXPECT_EQ(source->files(), (std::vector<std::string>{std::filesystem::canonical(path("vol")).string()}));
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

/// What other programs wrote, with what the voxels must be. A case that is not read is refused, and says why:
/// support cannot shrink unnoticed.
TEST_F(Precomputed, FoldersOfOtherPrograms) {
  const char* fixtures = std::getenv("CVRBENCH_FIXTURES");
  const std::filesystem::path folder =
      std::filesystem::path(fixtures == nullptr ? "" : fixtures) / "precomputed";
  if (!std::filesystem::is_regular_file(folder / "expected.json"))
    GTEST_SKIP() << "CVRBENCH_FIXTURES names no folder with precomputed/";
  const std::map<std::string, std::string> refusals{
      {"cloudvolume_compresso_u32/32_32_40",
       "encoding: expected raw or compressed_segmentation, which are read, found \"compresso\""},
      {"neuroglancer_one_channel/3_4_5", "expected the folder of a scale, found none"},
      {"neuroglancer_one_channel/6_8_10", "expected the folder of a scale, found none"},
      {"neuroglancer_one_channel/12_16_20", "expected the folder of a scale, found none"},
      {"neuroglancer_two_channels/3_4_5", "num_channels: expected 1"},
      {"neuroglancer_two_channels/6_8_10", "num_channels: expected 1"},
      {"neuroglancer_two_channels/12_16_20", "num_channels: expected 1"},
      {"raw_u8_two_channels/2_2_5", "num_channels: expected 1"},
      {"ngs_jpeg_u8/4mm", "found \"jpeg\""},
      {"png_u8/2_2_5", "found \"png\""},
      {"ngs_sharded_identity_u32/32mm", "sharding: expected an unsharded scale"},
      {"cv_sharded_murmur_gz_gz_u64/32_32_40", "sharding: expected an unsharded scale"},
      {"cv_sharded_murmur_gz_gz_u64/64_64_80", "sharding: expected an unsharded scale"},
      {"cv_sharded_identity_single_u8/4.5_4.5_12.25", "sharding: expected an unsharded scale"},
      {"cv_sharded_murmur_raw_raw_u16_missing/16_16_40", "sharding: expected an unsharded scale"},
  };
  std::size_t read = 0, refused = 0;
  for (const auto& one : nlohmann::json::parse(read_bytes((folder / "expected.json").string()))) {
    for (const auto& expected : one.at("volumes")) {
      const std::string open = expected.at("open");  // "scale N (key KEY)"
      const std::size_t start = open.find("(key ") + 5;
      const std::string name =
          one.at("path").get<std::string>() + "/" + open.substr(start, open.size() - 1 - start);
      SCOPED_TRACE(name);
      const std::string whole = (folder / name).string();
      if (const auto refusal = refusals.find(name); refusal != refusals.end()) {
        ++refused;
        try {
          open_volume(whole);
          ADD_FAILURE() << "was read";
        } catch (const InputError& error) {
          EXPECT_NE(std::string(error.what()).find(refusal->second), std::string::npos) << error.what();
        }
        continue;
      }
      ++read;
      expect_volume(whole, expected);
    }
  }
  EXPECT_EQ(read, 5u);
  EXPECT_EQ(refused, refusals.size());
}

}  // namespace
}  // namespace cvr::volumes
