// What the tests of readers and writers share: a folder of their own, volumes without symmetry, and
// bytes written by hand.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volumes/io/gzip.hpp"
#include "volumes/io/io.hpp"

namespace cvr::volumes {

/// Twelve voxels of one byte: 0 .. 11.
inline const std::string kTwelve("\0\1\2\3\4\5\6\7\10\11\12\13", 12);

/// Voxels that differ along every axis, with the smallest and the largest value of the type among
/// them.
inline Volume patterned(const Extent& extent, VoxelType type, VolumeKind kind) {
  Volume volume({.extent = extent,
                 .type = type,
                 .kind = kind,
                 .voxel_size = {8.0, 4.5, 40.0},
                 .voxel_unit = std::string("nm")});
  const std::size_t width = size_of(type);
  for (std::uint64_t i = 0; i < extent.voxels(); ++i) {
    const std::uint64_t value = (i / 7) * 0x9e3779b97f4a7c15u + i;
    if (type == VoxelType::kF32) {
      const float real = static_cast<float>(i) * 0.37f - 11.0f;
      std::memcpy(volume.data() + i * width, &real, width);
    } else {
      std::memcpy(volume.data() + i * width, &value, width);
    }
  }
  if (type != VoxelType::kF32) {
    std::memset(volume.data(), 0, width);
    std::memset(volume.data() + (extent.voxels() - 1) * width, 0xff, width);
  }
  return volume;
}

inline std::string big_endian_bytes(const Volume& volume) {
  std::string bytes(reinterpret_cast<const char*>(volume.data()), volume.bytes().size());
  const auto width = static_cast<std::ptrdiff_t>(size_of(volume.info().type));
  for (auto at = bytes.begin(); at != bytes.end(); at += width) std::reverse(at, at + width);
  return bytes;
}

inline std::string plain_bytes(const Volume& volume) {
  return {reinterpret_cast<const char*>(volume.data()), volume.bytes().size()};
}

inline std::string gzipped(std::string_view bytes) {
  std::string stream;
  GzipWriter gzip(
      [&](std::span<const std::byte> piece) {
        stream.append(reinterpret_cast<const char*>(piece.data()), piece.size());
      },
      6);
  gzip.write(std::as_bytes(std::span(bytes)));
  gzip.finish();
  return stream;
}

class IoTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "cvrbench-io-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string write_bytes(const std::string& name, std::string_view bytes) const {
    const std::filesystem::path file(path(name));
    std::filesystem::create_directories(file.parent_path());
    std::filesystem::remove(
        file);  // cutting an existing file short makes some file systems wait for the disk
    std::ofstream(file, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file.string();
  }

  std::string read_bytes(const std::string& file) const {
    std::ifstream stream(file, std::ios::binary);
    EXPECT_TRUE(stream.is_open()) << file;
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  /// Opening (and reading) must throw an InputError that names the file and says all of `parts`.
  void expect_error(const std::string& name, const std::vector<std::string>& parts,
                    std::optional<VolumeKind> kind = std::nullopt) const {
    expect_error(name, parts, OpenOptions{.kind = kind, .axes = {}});
  }
  void expect_error(const std::string& name, const std::vector<std::string>& parts,
                    const OpenOptions& options) const {
    try {
      const auto source = open_volume(name, options);
      std::byte voxel[8];
      source->read({{0, 0, 0}, {1, 1, 1}}, voxel);
      ADD_FAILURE() << name << " was read";
    } catch (const InputError& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find(folder_.string()), std::string::npos) << text;
      EXPECT_NE(text.find("expected"), std::string::npos) << text;
      EXPECT_NE(text.find("found"), std::string::npos) << text;
      for (const std::string& part : parts)
        EXPECT_NE(text.find(part), std::string::npos) << text << " lacks " << part;
    }
  }

  /// Nothing but these names lies in the test's folder: no temporary file was left behind.
  void expect_files(std::vector<std::string> names) const {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      found.push_back(entry.path().filename().string());
    std::sort(found.begin(), found.end());
    std::sort(names.begin(), names.end());
    EXPECT_EQ(found, names);
  }

  std::filesystem::path folder_;
};

/// A box read must equal the same box of the whole volume, for boxes inside, at the borders and of
/// one voxel.
inline void expect_boxes(const VolumeSource& source, const Volume& truth) {
  const Extent& e = truth.extent();
  const std::array boxes{
      Box{{0, 0, 0}, e},
      Box{{0, 0, e.z / 2}, {e.x, e.y, 1}},
      Box{{e.x - 1, e.y - 1, e.z - 1}, {1, 1, 1}},
      Box{{e.x / 3, e.y / 4, e.z / 5}, {e.x - e.x / 3, e.y - e.y / 4, e.z - e.z / 5}},
      Box{{1 % e.x, 0, 0}, {1, e.y, e.z}},
  };
  const MemorySource memory(truth);
  const std::size_t width = size_of(truth.info().type);
  for (const Box& box : boxes) {
    std::vector<std::byte> expected(box.size.voxels() * width), found(expected.size());
    memory.read(box, expected.data());
    source.read(box, found.data());
    EXPECT_EQ(found, expected) << to_string(box.size) << " at " << box.origin.x << ","
                               << box.origin.y << "," << box.origin.z;
  }
}

}  // namespace cvr::volumes
