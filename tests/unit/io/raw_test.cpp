// Raw voxels with a sidecar: zero copy, byte order, offsets, and positions in the errors of the sidecar.
#include "io_fixture.hpp"

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
  EXPECT_EQ(read_bytes(path("a.raw.yaml")),
            "extent: [70, 13, 67]\ntype: u32\nkind: labels\nvoxel_size: [8, 4.5, 40]\nvoxel_unit: nm\n");
}

TEST_F(Raw, TheFirstAxisIsX) {
  const Volume volume = read_all(*open_volume(make("extent: [2, 3, 1]\ntype: u8\n", "abcdef")));
  EXPECT_EQ(volume.label({1, 0, 0}), std::uint64_t{'b'});
  EXPECT_EQ(volume.label({0, 1, 0}), std::uint64_t{'c'});
}

TEST_F(Raw, ByteOrderAndOffset) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU64, VolumeKind::kLabels);
  const auto big = open_volume(make("extent: [5, 7, 3]\ntype: u64\nbyte_order: big\noffset_bytes: 3\n",
                                    "xyz" + big_endian_bytes(volume)));
  EXPECT_EQ(big->data(), nullptr);
  expect_boxes(*big, volume);
  const auto odd =
      open_volume(make("extent: [5, 7, 3]\ntype: u64\noffset_bytes: 3\n", "xyz" + plain_bytes(volume)));
  EXPECT_EQ(odd->data(), nullptr) << "misaligned voxels must not be handed out";
  expect_boxes(*odd, volume);
}

TEST_F(Raw, ErrorsOfTheSidecarHavePositions) {
  expect_error(make("extent: [2, 3, 1]\ntype: u8\n  color: red\n", "abcdef"), {"a.raw.yaml", "YAML"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\ncolor: red\n", "abcdef"), {"a.raw.yaml: 3:1", "'color'"});
  expect_error(make("extent: [2, 3]\ntype: u8\n", "abcdef"), {"1:9"});
  expect_error(make("extent: [2, -3, 1]\ntype: u8\n", "abcdef"), {"1:13", "'-3'"});
  expect_error(make("extent: [2, 3.5, 1]\ntype: u8\n", "abcdef"), {"1:13", "'3.5'"});
  expect_error(make("extent: [2, 3, 1]\ntype: u128\n", "abcdef"), {"2:7", "'u128'"});
  expect_error(make("extent: [2, 3, 1]\n", "abcdef"), {"'type'"});
  expect_error(make("type: u8\n", "abcdef"), {"'extent'"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\nkind: colours\n", "abcdef"), {"3:7", "'colours'"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\nvoxel_size: [1, 0, 1]\n", "abcdef"), {"3:13"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\nbyte_order: middle\n", "abcdef"), {"3:13", "'middle'"});
  expect_error(make("extent: [2, 3, 1]\ntype: u8\noffset_bytes: -1\n", "abcdef"), {"3:15", "'-1'"});
  expect_error(make("- a\n- list\n", "abcdef"), {"a.raw.yaml"});
  expect_error(make("", "abcdef"), {"a.raw.yaml"});
  expect_error(make("extent: [2, 3, 1]\ntype: f32\nkind: labels\n", "abcdefabcdefabcdefabcdef"), {"f32"});
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
