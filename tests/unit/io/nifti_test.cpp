// NIfTI-1: the exact header that we write, headers of both byte orders made by hand, and what is refused.
#include <nifti/nifti1.h>

#include <cmath>

#include "io_fixture.hpp"

namespace cvr::volumes {
namespace {

/// Header, 4 bytes of extension flag, and no voxels; fields at their byte offsets of the specification.
class HeaderBytes {
 public:
  explicit HeaderBytes(bool big_endian = false) : big_endian_(big_endian), bytes_(352, '\0') {
    put<std::int32_t>(0, 348);
    for (int axis = 0; axis < 8; ++axis) put<std::int16_t>(40 + 2 * axis, axis == 0 ? 3 : 1);
    dims(2, 3, 2).type(DT_UINT8, 8);
    for (int axis = 0; axis < 4; ++axis) put<float>(76 + 4 * axis, 1);
    put<float>(108, 352);
    std::memcpy(bytes_.data() + 344, "n+1", 4);
  }
  template <class T>
  HeaderBytes& put(int offset, std::type_identity_t<T> value) {
    auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (big_endian_) std::reverse(raw.begin(), raw.end());
    std::memcpy(bytes_.data() + offset, raw.data(), raw.size());
    return *this;
  }
  HeaderBytes& dims(std::int16_t x, std::int16_t y, std::int16_t z) {
    put<std::int16_t>(42, x);
    put<std::int16_t>(44, y);
    return put<std::int16_t>(46, z);
  }
  HeaderBytes& type(std::int16_t code, std::int16_t bits) {
    put<std::int16_t>(70, code);
    return put<std::int16_t>(72, bits);
  }
  std::string with(const std::string& voxels) const { return bytes_ + voxels; }

 private:
  bool big_endian_;
  std::string bytes_;
};

const std::string kTwelve("\0\1\2\3\4\5\6\7\10\11\12\13", 12);

using Nifti = IoTest;

TEST_F(Nifti, TheFirstAxisIsX) {
  const auto source =
      open_volume(write_bytes("a.nii", HeaderBytes().put<std::int16_t>(68, 1002).with(kTwelve)));
  EXPECT_EQ(source->info().extent, (Extent{2, 3, 2}));
  EXPECT_EQ(source->info().kind, VolumeKind::kLabels);
  const Volume volume = read_all(*source);
  EXPECT_EQ(volume.label({1, 0, 0}), 1u);
  EXPECT_EQ(volume.label({0, 1, 0}), 2u);
  EXPECT_EQ(volume.label({0, 0, 1}), 6u);
}

TEST_F(Nifti, HeaderIsGolden) {
  Volume volume(
      {.extent = {3, 1, 2}, .type = VoxelType::kU16, .voxel_size = {0.5, 1, 2}, .voxel_unit = "mm"});
  for (std::uint16_t i = 0; i < 6; ++i)
    volume.voxels<std::uint16_t>()[i] = static_cast<std::uint16_t>(0x6160 + i);
  write_volume(path("a.nii"), MemorySource(volume));
  std::string expected(352, '\0');
  const auto put = [&expected](std::size_t offset, std::string_view bytes) {
    expected.replace(offset, bytes.size(), bytes);
  };
  using namespace std::string_view_literals;
  put(0, "\x5c\x01\0\0"sv);                                   // sizeof_hdr 348
  put(38, "r");                                               // regular
  put(40, "\3\0\3\0\1\0\2\0\1\0\1\0\1\0\1\0"sv);              // dim: 3 axes of 3, 1, 2
  put(68, "\xea\x03"sv);                                      // intent_code 1002, label
  put(70, "\0\2\x10\0"sv);                                    // datatype 512, 16 bits
  put(76, "\0\0\x80\x3f\0\0\0\x3f\0\0\x80\x3f\0\0\0\x40"sv);  // pixdim: qfac 1, 0.5, 1, 2
  put(108, "\0\0\xb0\x43\0\0\x80\x3f"sv);                     // vox_offset 352, scl_slope 1
  put(123, "\2"sv);                                           // millimetres
  put(328, "labels"sv);                                       // intent_name
  put(344, "n+1\0"sv);
  EXPECT_EQ(read_bytes(path("a.nii")), expected + "`aaabacadaea");
}

TEST_F(Nifti, BigEndianOfEveryWidth) {
  struct Case {
    std::int16_t code;
    VoxelType type;
    VolumeKind kind;
  };
  for (const Case& c : {Case{DT_UINT8, VoxelType::kU8, VolumeKind::kScalars},
                        Case{DT_UINT16, VoxelType::kU16, VolumeKind::kLabels},
                        Case{DT_UINT32, VoxelType::kU32, VolumeKind::kLabels},
                        Case{DT_UINT64, VoxelType::kU64, VolumeKind::kLabels},
                        Case{DT_INT16, VoxelType::kI16, VolumeKind::kScalars},
                        Case{DT_FLOAT32, VoxelType::kF32, VolumeKind::kScalars}}) {
    const Volume volume = patterned({5, 7, 3}, c.type, c.kind);
    HeaderBytes header(true);
    header.dims(5, 7, 3).type(c.code, static_cast<std::int16_t>(8 * size_of(c.type))).put<float>(84, -2.5f);
    const auto source = open_volume(write_bytes("a.nii", header.with(big_endian_bytes(volume))));
    EXPECT_EQ(source->info().kind, c.kind);
    EXPECT_EQ(source->info().voxel_size[1], 2.5);
    ASSERT_EQ(source->info().type, c.type);
    expect_boxes(*source, volume);
  }
}

TEST_F(Nifti, SeriesAreStacksOfSteps) {
  std::string voxels;
  for (int step = 0; step < 3; ++step) voxels += kTwelve;
  voxels[24 + 5] = 99;
  HeaderBytes header;
  header.put<std::int16_t>(40, 4).put<std::int16_t>(48, 3);
  const std::string name = write_bytes("a.nii", header.with(voxels));
  EXPECT_EQ(read_all(*open_volume(name + "[2]")).label({1, 2, 0}), 99u);
  EXPECT_EQ(read_all(*open_volume(name + "[1]")).label({1, 2, 0}), 5u);
  const auto whole = open_volume(name), later = open_volume(name + "[1:3]");
  EXPECT_EQ(whole->info().time_steps, 3u);
  EXPECT_EQ(whole->info().extent.z, 3 * open_volume(name + "[0]")->info().extent.z);
  EXPECT_EQ(later->info().time_steps, 2u);
  const std::string all = plain_bytes(read_all(*whole));
  EXPECT_EQ(all, voxels);
  EXPECT_EQ(plain_bytes(read_all(*later)), voxels.substr(12));
  expect_error(name + "[3]", {"from 0 to 2", "[3]"});
  expect_error(name + "[2:2]", {"B <= 3", "[2:2]"});
  expect_error(name + "[1:4]", {"B <= 3", "[1:4]"});
}

TEST_F(Nifti, SignedLabelsAreCheckedNotWrapped) {
  const auto make = [this](std::int16_t code, std::int16_t bits, const std::string& voxels) {
    return write_bytes("a.nii",
                       HeaderBytes().dims(2, 1, 1).type(code, bits).put<std::int16_t>(68, 1002).with(voxels));
  };
  EXPECT_EQ(read_all(*open_volume(make(DT_INT8, 8, "\1\x7f"))).label({1, 0, 0}), 127u);
  expect_error(make(DT_INT8, 8, "\xff\1"), {"-1"});
  EXPECT_EQ(read_all(*open_volume(make(DT_INT16, 16, std::string("\1\0\2\1", 4)))).label({1, 0, 0}), 258u);
  expect_error(make(DT_INT16, 16, std::string("\xfe\xff\2\1", 4)), {"-2"});
  EXPECT_EQ(read_all(*open_volume(make(DT_INT32, 32, std::string("\1\0\0\0\2\1\0\0", 8)))).label({1, 0, 0}),
            258u);
  expect_error(make(DT_INT32, 32, std::string("\xfd\xff\xff\xff\2\1\0\0", 8)), {"-3"});
}

TEST_F(Nifti, RefusesWhatItCannotRead) {
  const auto refuse = [this](const HeaderBytes& header, const std::vector<std::string>& parts) {
    expect_error(write_bytes("a.nii", header.with(kTwelve)), parts);
  };
  refuse(HeaderBytes().put<float>(112, 2), {"scl_slope", "slope 2"});
  refuse(HeaderBytes().put<float>(112, 1).put<float>(116, -1024), {"intercept -1024"});
  refuse(HeaderBytes().type(DT_FLOAT64, 64), {"datatype", "64"});
  refuse(HeaderBytes().type(DT_RGB24, 24), {"datatype", "128"});
  refuse(HeaderBytes().type(DT_UINT8, 16), {"bitpix", "16"});
  refuse(HeaderBytes().put<std::int32_t>(0, 540), {"sizeof_hdr 540"});
  refuse(HeaderBytes().put<std::int16_t>(40, 9), {"dim[0]"});
  refuse(HeaderBytes().dims(2, 0, 2), {"dim[2]", "0"});
  refuse(HeaderBytes().dims(2, 3, -2), {"dim[3]", "-2"});
  refuse(HeaderBytes().put<std::int16_t>(40, 5).put<std::int16_t>(50, 3), {"dim[5]", "3"});
  refuse(HeaderBytes().put<float>(108, 12), {"vox_offset", "12"});
  refuse(HeaderBytes().put<float>(108, 352.5f), {"vox_offset", "352.5"});
  refuse(HeaderBytes().put<float>(108, NAN), {"vox_offset", "nan"});
  refuse(HeaderBytes().put<float>(80, INFINITY), {"pixdim", "inf"});
  refuse(HeaderBytes().put<std::int32_t>(344, 0x0031696e), {"ni1"});
  refuse(HeaderBytes().put<std::int32_t>(344, 0), {"magic"});
  refuse(HeaderBytes().dims(32767, 32767, 32767), {"35181150961663"});
  refuse(HeaderBytes().dims(32767, 32767, 32767).type(DT_UINT64, 64), {"281449207693304"});
}

TEST_F(Nifti, WritesOnlyWhatTheHeaderCanSay) {
  const Volume wide({.extent = {40000, 1, 1}, .type = VoxelType::kU8, .voxel_unit = {}});
  EXPECT_THROW(write_volume(path("a.nii"), MemorySource(wide)), InputError);
  const Volume odd({.extent = {1, 1, 1}, .type = VoxelType::kU8, .voxel_unit = "px"});
  EXPECT_THROW(write_volume(path("a.nii"), MemorySource(odd)), InputError);
  expect_files({});
}

TEST_F(Nifti, ReadsTheAtlasesOfMricron) {
  const std::filesystem::path folder("/usr/share/mricron/templates");
  if (!std::filesystem::exists(folder / "aal.nii.gz"))
    GTEST_SKIP() << "the Debian package mricron-data is absent";
  const auto labels = open_volume((folder / "aal.nii.gz").string());
  EXPECT_EQ(labels->info().extent, (Extent{181, 217, 181}));
  EXPECT_EQ(labels->info().type, VoxelType::kU8);
  EXPECT_EQ(labels->info().kind, VolumeKind::kLabels);
  const Volume volume = read_all(*labels);
  std::vector<bool> seen(256);
  for (const std::uint8_t label : volume.voxels<std::uint8_t>()) seen[label] = true;
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 117);
  const auto scalars = open_volume((folder / "ch2.nii.gz").string());
  EXPECT_EQ(scalars->info().extent, (Extent{181, 217, 181}));
  EXPECT_EQ(scalars->info().kind, VolumeKind::kScalars);
  EXPECT_EQ(open_volume((folder / "ch2.nii.gz").string(), VolumeKind::kLabels)->info().kind,
            VolumeKind::kLabels);
}

}  // namespace
}  // namespace cvr::volumes
