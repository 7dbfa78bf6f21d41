// Raw voxels with a sidecar: zero copy, byte order, offsets, and positions in the errors of the
// sidecar.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cmath>

#include "tests/unit/volumes/io/io_fixture.hpp"

namespace cvr::volumes {
namespace {

class Raw : public IoTest {
 protected:
  std::string make(const std::string& sidecar, const std::string& voxels) const {
    write_bytes("a.raw.yaml", sidecar);
    return write_bytes("a.raw", voxels);
  }
};

TEST_F(Raw, IsMappedWithoutACopy) {
  const Volume volume = patterned({70, 13, 67}, VoxelType::kU32, VolumeKind::kLabels);
  write_volume(path("a.raw"), MemorySource(volume));
  const auto source = open_volume(path("a.raw"));
  ASSERT_NE(source->data(), nullptr);
  EXPECT_EQ(std::memcmp(source->data(), volume.data(), volume.bytes().size()), 0);
  EXPECT_EQ(read_bytes(path("a.raw")), plain_bytes(volume));
  EXPECT_EQ(
      read_bytes(path("a.raw.yaml")),
      "extent: [70, 13, 67]\ntype: u32\nkind: labels\nvoxel_size: [8, 4.5, 40]\nvoxel_unit: nm\n");
}

TEST_F(Raw, TheFirstAxisIsX) {
  const Volume volume = read_all(*open_volume(make("extent: [2, 3, 1]\ntype: u8\n", "abcdef")));
  EXPECT_EQ(volume.label({1, 0, 0}), std::uint64_t{'b'});
  EXPECT_EQ(volume.label({0, 1, 0}), std::uint64_t{'c'});
}

TEST_F(Raw, ByteOrderAndOffset) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU64, VolumeKind::kLabels);
  const auto big =
      open_volume(make("extent: [5, 7, 3]\ntype: u64\nbyte_order: big\noffset_bytes: 3\n",
                       "xyz" + big_endian_bytes(volume)));
  EXPECT_EQ(big->data(), nullptr);
  expect_boxes(*big, volume);
  const auto odd = open_volume(
      make("extent: [5, 7, 3]\ntype: u64\noffset_bytes: 3\n", "xyz" + plain_bytes(volume)));
  EXPECT_EQ(odd->data(), nullptr) << "misaligned voxels must not be handed out";
  expect_boxes(*odd, volume);
}

TEST_F(Raw, ErrorsOfTheSidecarHavePositions) {
  expect_error(make("extent: [2, 3, 1]\ntype: u8\n  color: red\n", "abcdef"),
               {"a.raw.yaml", "YAML"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\ncolor: red\n", "abcdef"),
               {"a.raw.yaml:3:1", "'color'"});
  expect_error(make("extent: [2, 3]\ntype: u8\n", "abcdef"), {"1:9"});
  expect_error(make("extent: [2, -3, 1]\ntype: u8\n", "abcdef"), {"1:13", "'-3'"});
  expect_error(make("extent: [2, 3.5, 1]\ntype: u8\n", "abcdef"), {"1:13", "'3.5'"});
  expect_error(make("extent: [2, 3, 1]\ntype: u128\n", "abcdef"), {"2:7", "'u128'"});
  expect_error(make("extent: [2, 3, 1]\n", "abcdef"), {"'type'"});
  expect_error(make("type: u8\n", "abcdef"), {"'extent'"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\nkind: colours\n", "abcdef"),
               {"3:7", "'colours'"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\nvoxel_size: [1, 0, 1]\n", "abcdef"),
               {"3:17", "positive", "'0'"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\nbyte_order: middle\n", "abcdef"),
               {"3:13", "'middle'"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\noffset_bytes: -1\n", "abcdef"), {"3:15", "'-1'"});
  expect_error(make("- a\n- list\n", "abcdef"), {"a.raw.yaml"});
  expect_error(make("", "abcdef"), {"a.raw.yaml"});
  expect_error(make("extent: [2, 3, 1]\ntype: f32\nkind: labels\n", "abcdefabcdefabcdefabcdef"),
               {"f32", "voxel (0, 0, 0)"});
}

TEST_F(Raw, TheSidecarObeysTheRulesOfConfigurations) {
  const std::string good = "extent: [2, 3, 1]\ntype: u8\n";
  expect_error(make(good + "type: i16\n", "abcdef"), {"a.raw.yaml:3:1", "'type' again"});
  expect_error(make(good + "extent: [3, 2, 1]\n", "abcdef"), {"a.raw.yaml:3:1", "'extent' again"});
  expect_error(make(good + "---\ntype: u8\n", "abcdef"),
               {"a.raw.yaml:", "one YAML document, found a second one"});
  expect_error(make(good + "voxl_size: [1, 1, 1]\n", "abcdef"),
               {"'voxl_size' (did you mean 'voxel_size'?)"});
  expect_error(make("extent: [2, 010, 1]\ntype: u8\n", "abcdef"),
               {"1:13", "'010'", "without leading zeros"});
  expect_error(make("extent: [2, 18446744073709551617, 1]\ntype: u8\n", "abcdef"),
               {"1:13", "'18446744073709551617'"});
  expect_error(make(good + "steps: 0\n", "abcdef"), {"3:8", "'0'"});
  expect_error(make(good + "offset: [1, .nan, 0]\n", "abcdef"), {"3:13"});
  std::filesystem::remove(path("a.raw.yaml"));
  ASSERT_EQ(::mkfifo(path("a.raw.yaml").c_str(), 0600), 0);
  expect_error(path("a.raw"), {"a.raw.yaml", "device, pipe or socket"});
}

TEST_F(Raw, TheOffsetIsKept) {
  const auto source =
      open_volume(make("extent: [2, 3, 1]\ntype: u8\noffset: [-0.5, 1e9, 3]\n", "abcdef"));
  EXPECT_EQ(source->info().offset, (std::array<double, 3>{-0.5, 1e9, 3}));
  EXPECT_THAT(source->files(), testing::UnorderedElementsAre(path("a.raw"), path("a.raw.yaml")));
}

TEST_F(Raw, AxesInAnyOrder) {
  const std::string name = make(
      "extent: [2, 3, 1]\ntype: u16\nbyte_order: big\nvoxel_size: [5, 6, 7]\noffset: [1, 2, 3]\n",
      std::string("\0\1\0\2\0\3\0\4\0\5\0\6", 12));
  const auto turned = open_volume(name, OpenOptions{.axes = "yx"});
  EXPECT_EQ(turned->info().extent, (Extent{3, 2, 1}));
  EXPECT_EQ(turned->info().voxel_size, (std::array<double, 3>{6, 5, 1}));
  EXPECT_EQ(turned->info().offset, (std::array<double, 3>{2, 1, 0}));
  EXPECT_EQ(turned->data(), nullptr);
  const Volume volume = read_all(*turned);
  EXPECT_EQ(volume.label({0, 1, 0}), 2u);
  EXPECT_EQ(volume.label({1, 0, 0}), 3u);
  expect_boxes(*turned, volume);
  EXPECT_EQ(open_volume(name, OpenOptions{.axes = "zxy"})->info().extent, (Extent{3, 1, 2}));
  const auto series = open_volume(name, OpenOptions{.axes = "tyx"});
  EXPECT_EQ(series->info().time_steps, 2u);
  EXPECT_EQ(read_all(*series).label({0, 0, 1}), 2u);
  EXPECT_EQ(read_all(*open_volume(name + "[1]", OpenOptions{.axes = "tyx"})).label({0, 2, 0}), 6u);
  for (const char* axes : {"x", "xyzt", "xx", "xyq", "xy z"}) {
    expect_error(name, {"2 x 3 x 1", axes}, OpenOptions{.axes = axes});
  }
  expect_error(name, {"axis 1", "2 channels"}, OpenOptions{.axes = "cxy"});
}

TEST_F(Raw, WholeFloatsAreLabels) {
  Volume volume({.extent = {4, 1, 1},
                 .type = VoxelType::kF32,
                 .kind = VolumeKind::kScalars,
                 .voxel_unit = {}});
  const auto with_last = [&](float last) {
    const std::array values{0.0f, -0.0f, 16777216.0f, last};
    std::memcpy(volume.data(), values.data(), sizeof values);
    return make("extent: [4, 1, 1]\ntype: f32\n", plain_bytes(volume));
  };
  const auto source = open_volume(with_last(7), VolumeKind::kLabels);
  EXPECT_EQ(source->info().type, VoxelType::kU32);
  EXPECT_EQ(source->data(), nullptr);
  const Volume labels = read_all(*source);
  EXPECT_EQ(labels.label({1, 0, 0}), 0u);
  EXPECT_EQ(labels.label({2, 0, 0}), 16777216u);
  EXPECT_EQ(labels.label({3, 0, 0}), 7u);
  EXPECT_EQ(open_volume(path("a.raw"))->info().kind, VolumeKind::kScalars);
  for (const auto& [value, text] : {std::pair{1.5f, "1.5"},
                                    {-1.0f, "-1"},
                                    {NAN, "nan"},
                                    {INFINITY, "inf"},
                                    {16777218.0f, "16777218"}}) {
    const auto bad = open_volume(with_last(value), VolumeKind::kLabels);
    try {
      read_all(*bad);
      ADD_FAILURE() << value;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("voxel (3, 0, 0)"));
      EXPECT_THAT(error.what(), testing::HasSubstr(std::string("found ") + text));
    }
  }
}

TEST_F(Raw, TheSizeMustFitExactly) {
  expect_error(make("extent: [2, 3, 1]\ntype: u8\n", "abcde"), {"6 bytes", "5 bytes"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\n", "abcdefg"), {"6 bytes", "7 bytes"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\noffset_bytes: 99\n", "abcdef"), {"99 + 6"});
  expect_error(make("extent: [1048576, 1048576, 1048576]\ntype: u8\n", "abcdef"), {"2^48"});
  expect_error(make("extent: [0, 3, 1]\ntype: u8\n", ""), {"0x3x1"});
  write_bytes("b.raw", "abcdef");
  expect_error(path("b.raw"), {"b.raw.yaml"});
}

}  // namespace
}  // namespace cvr::volumes
