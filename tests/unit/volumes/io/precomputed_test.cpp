// Reading Neuroglancer precomputed: chunks made by hand with an offset and partial borders, gzip,
// missing chunks, and what must not pass for zeros.
#include <fmt/format.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "tests/unit/volumes/io/precomputed_fixture.hpp"

namespace cvr::volumes {
namespace {

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
  write_bytes("vol/info",
              R"({"type": "segmentation", "data_type": "uint64", "num_channels": 1, "scales": [
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
  refuse("/scales/0/sharding", {{"@type", "neuroglancer_uint64_sharded_v1"}},
         {"sharding", "unsharded"});
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
       {"10-12_-4--2_100-102.br", "10-12_-4--2_100-102.zst", "10-12_-4--2_100-102.part0",
        "0-2_-4--2_100-102", "10-13_-4--2_100-102", "12-14_-4--2_100-102", "14-16_-4--2_100-102",
        "0.shard", "notes.txt", "99999999999999999999-1_0-1_0-1"}) {
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
  write_bytes("vol/8_8_40/10-12_-4--2_100-102.gz",
              gzipped(read_bytes(name + "/8_8_40/10-12_-4--2_100-102")));
  expect_error(name, {"10-12_-4--2_100-102", "one file of a chunk"});
}

TEST_F(Precomputed, ChunksOfSeveralSizesLieInOneFolder) {
  const std::string name = make_small();
  nlohmann::json info = small_info();
  info["scales"][0]["chunk_sizes"] = {{2, 2, 2}, {3, 1, 3}};
  write_bytes("vol/info", info.dump());
  write_bytes("vol/8_8_40/10-13_-4--3_100-103", "123456789");
  expect_small(*open_volume(name));
  for (const char* chunk :
       {"10-12_-4--2_100-102", "12-13_-4--2_100-102", "10-12_-4--2_102-103", "12-13_-4--2_102-103"})
    ASSERT_TRUE(std::filesystem::remove(path("vol/8_8_40/") + chunk)) << chunk;
  expect_error(name, {"at least one chunk file", "10-12_-4--2_100-102"});
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
  expect_error(path("vol"), {"expected each key once, found \"data_type\""});
  const std::string size = "\"size\":[3,2,3],";
  text.insert(text.find("\"size\""), size);
  write_bytes("vol/info", text);
  expect_error(path("vol"), {"expected each key once, found \"size\""});
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
              .find(fmt::format(
                  "axes: expected none, xyz or xyzc, since precomputed volumes are stored so, "
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

}  // namespace
}  // namespace cvr::volumes
