// NIfTI-1: the exact header that we write, headers of both byte orders made by hand, and what is
// refused.
#include <nifti/nifti1.h>

#include <cmath>

#include "tests/unit/volumes/io/io_fixture.hpp"

namespace cvr::volumes {
namespace {

/// Header, 4 bytes of extension flag, and no voxels; fields at their byte offsets of the
/// specification.
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
  Volume volume({.extent = {3, 1, 2},
                 .type = VoxelType::kU16,
                 .voxel_size = {0.5, 1, 2},
                 .voxel_unit = "mm"});
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
    header.dims(5, 7, 3)
        .type(c.code, static_cast<std::int16_t>(8 * size_of(c.type)))
        .put<float>(84, -2.5f);
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
    return write_bytes(
        "a.nii",
        HeaderBytes().dims(2, 1, 1).type(code, bits).put<std::int16_t>(68, 1002).with(voxels));
  };
  EXPECT_EQ(read_all(*open_volume(make(DT_INT8, 8, "\1\x7f"))).label({1, 0, 0}), 127u);
  expect_error(make(DT_INT8, 8, "\xff\1"), {"-1"});
  EXPECT_EQ(read_all(*open_volume(make(DT_INT16, 16, std::string("\1\0\2\1", 4)))).label({1, 0, 0}),
            258u);
  expect_error(make(DT_INT16, 16, std::string("\xfe\xff\2\1", 4)), {"-2"});
  EXPECT_EQ(read_all(*open_volume(make(DT_INT32, 32, std::string("\1\0\0\0\2\1\0\0", 8))))
                .label({1, 0, 0}),
            258u);
  expect_error(make(DT_INT32, 32, std::string("\xfd\xff\xff\xff\2\1\0\0", 8)), {"-3"});
}

TEST_F(Nifti, RefusesWhatItCannotRead) {
  const auto refuse = [this](const HeaderBytes& header, const std::vector<std::string>& parts) {
    expect_error(write_bytes("a.nii", header.with(kTwelve)), parts);
  };
  refuse(HeaderBytes().put<float>(112, 2), {"scl_slope", "slope 2"});
  refuse(HeaderBytes().put<float>(112, 1).put<float>(116, -1024), {"intercept -1024"});
  refuse(HeaderBytes().put<float>(112, 1).put<float>(116, NAN), {"intercept nan"});
  refuse(HeaderBytes().put<float>(112, INFINITY), {"slope inf"});
  refuse(HeaderBytes().type(DT_FLOAT64, 64), {"float64 (NIfTI code 64)", "--kind labels"});
  refuse(HeaderBytes().type(DT_RGB24, 24), {"datatype", "RGB24 (NIfTI code 128)"});
  refuse(HeaderBytes().type(DT_COMPLEX64, 64), {"complex64 (NIfTI code 32)"});
  refuse(HeaderBytes().type(DT_FLOAT128, 128), {"float128 (NIfTI code 1536)"});
  refuse(HeaderBytes().type(77, 8), {"an unknown type (NIfTI code 77)"});
  refuse(HeaderBytes().type(DT_UINT8, 16), {"bitpix", "16"});
  refuse(HeaderBytes().put<std::int32_t>(0, 540), {"sizeof_hdr 540"});
  refuse(HeaderBytes().put<std::int32_t>(0, 0x1c020000), {"NIfTI-2"});
  refuse(HeaderBytes().put<std::int32_t>(0, 347), {"348", "other bytes"});
  for (const std::int16_t rank : {0, 8, 9, -1}) {
    refuse(HeaderBytes().put<std::int16_t>(40, rank),
           {"1 to 7 axes", "dim[0] " + std::to_string(rank)});
    refuse(HeaderBytes(true).put<std::int16_t>(40, rank),
           {"dim[0] " + std::to_string(rank), "big-endian"});
  }
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

TEST_F(Nifti, SurplusAndMissingBytesAreErrors) {
  for (const char* name : {"a.nii", "b.nii.gz"}) {
    const Volume volume = patterned({5, 7, 3}, VoxelType::kU16, VolumeKind::kLabels);
    write_volume(path("whole.nii"), MemorySource(volume));
    const std::string whole = read_bytes(path("whole.nii"));
    for (const auto& [bytes, numbers] : {std::pair{whole + "x", std::array{"210", "211"}},
                                         {whole.substr(0, whole.size() - 1), {"210", "209"}}}) {
      if (std::string(name).ends_with("gz")) {
        expect_error(write_bytes(name, gzipped(bytes)), {"562", std::to_string(bytes.size())});
      } else {
        expect_error(write_bytes(name, bytes), {numbers[0], numbers[1]});
      }
    }
  }
}

TEST_F(Nifti, NotANumberAsASlopeMeansUnscaled) {
  for (const float slope : {NAN, 0.0f}) {
    const auto source = open_volume(write_bytes(
        "a.nii", HeaderBytes().put<float>(112, slope).put<float>(116, slope).with(kTwelve)));
    EXPECT_EQ(plain_bytes(read_all(*source)), kTwelve);
  }
}

TEST_F(Nifti, ExtensionsAreSkipped) {
  std::string extension(32, 'e');
  extension.replace(0, 8, std::string("\x20\0\0\0\6\0\0\0", 8));
  const HeaderBytes header = HeaderBytes().put<float>(108, 384).put<std::int32_t>(348, 1);
  EXPECT_EQ(
      plain_bytes(read_all(*open_volume(write_bytes("a.nii", header.with(extension + kTwelve))))),
      kTwelve);
  EXPECT_EQ(plain_bytes(read_all(
                *open_volume(write_bytes("a.nii.gz", gzipped(header.with(extension + kTwelve)))))),
            kTwelve);
  extension[0] = 0x30;
  expect_error(write_bytes("a.nii", header.with(extension + kTwelve)),
               {"byte 352", "48 bytes", "384"});
}

TEST_F(Nifti, TheOffsetIsThatOfTheTransform) {
  HeaderBytes header;
  header.put<std::int16_t>(252, 1);  // qform_code; quaternions of the identity
  header.put<float>(268, 10.25f).put<float>(272, -20).put<float>(276, 0.1f);
  EXPECT_EQ(open_volume(write_bytes("a.nii", header.with(kTwelve)))->info().offset,
            (std::array<double, 3>{10.25, -20, 0.1}));
  header.put<std::int16_t>(254,
                           2);  // sform_code goes before; x runs backwards, y and z are exchanged
  header.put<float>(280, -2)
      .put<float>(292, 5)
      .put<float>(304, 3)
      .put<float>(308, 6)
      .put<float>(316, 4)
      .put<float>(324, 7);
  EXPECT_EQ(open_volume(write_bytes("a.nii", header.with(kTwelve)))->info().offset,
            (std::array<double, 3>{5, 7, 6}));
  header.put<float>(284, 1);  // oblique
  EXPECT_EQ(open_volume(write_bytes("a.nii", header.with(kTwelve)))->info().offset,
            (std::array<double, 3>{5, 6, 7}));
  EXPECT_EQ(open_volume(write_bytes("a.nii", HeaderBytes().put<float>(268, 3).with(kTwelve)))
                ->info()
                .offset,
            (std::array<double, 3>{}))
      << "no code, no transform";
  expect_error(write_bytes("a.nii", header.put<float>(292, NAN).with(kTwelve)), {"srow_x", "nan"});
}

TEST_F(Nifti, AxesMayBeNamed) {
  HeaderBytes header;
  header.put<std::int16_t>(40, 5).put<std::int16_t>(46, 1).put<std::int16_t>(
      50, 2);  // 2 x 3 x 1 x 1 x 2
  const std::string name = write_bytes("a.nii", header.with(kTwelve));
  expect_error(name, {"dim[5]", "found 2", "--axes"});
  for (const char* axes : {"xyt", "xyzct"}) {
    const auto series = open_volume(name, OpenOptions{.axes = axes});
    EXPECT_EQ(series->info().time_steps, 2u);
    EXPECT_EQ(plain_bytes(read_all(*series)), kTwelve);
  }
  const Volume turned = read_all(*open_volume(name, OpenOptions{.axes = "zyx"}));
  EXPECT_EQ(turned.extent(), (Extent{2, 3, 2}));
  EXPECT_EQ(turned.label({1, 0, 0}), 6u);
  EXPECT_EQ(turned.label({0, 2, 1}), 5u);
  expect_error(name, {"2 x 3 x 1 x 1 x 2", "'xy'"}, OpenOptions{.axes = "xy"});
  expect_error(name, {"2 channels"}, OpenOptions{.axes = "xyc"});
}

TEST_F(Nifti, DoublesThatAreWholeNumbersAreLabels) {
  const std::array values{9007199254740992.0, 3.0};
  std::string bytes(16, '\0');
  std::memcpy(bytes.data(), values.data(), 16);
  HeaderBytes header;
  header.dims(2, 1, 1).type(DT_FLOAT64, 64);
  const auto source = open_volume(write_bytes("A.NII", header.with(bytes)), VolumeKind::kLabels);
  EXPECT_EQ(source->info().type, VoxelType::kU64);
  EXPECT_EQ(read_all(*source).label({0, 0, 0}), 9007199254740992u);
  EXPECT_EQ(read_all(*source).label({1, 0, 0}), 3u);
  EXPECT_EQ(read_all(*open_volume(write_bytes("A.NII.GZ", gzipped(header.with(bytes))),
                                  VolumeKind::kLabels))
                .label({1, 0, 0}),
            3u);
}

TEST_F(Nifti, WritesOffsetsOrSaysThatItCannot) {
  Volume volume({.extent = {1, 1, 1},
                 .type = VoxelType::kU8,
                 .voxel_size = {4, 4, 40},
                 .voxel_unit = "nm",
                 .offset = {1200.5, -4, 0}});
  volume.data()[0] = std::byte{1};
  write_volume(path("a.nii"), MemorySource(volume));
  EXPECT_EQ(open_volume(path("a.nii"))->info().offset, (std::array<double, 3>{1.2005, -0.004, 0}));
  EXPECT_EQ(open_volume(path("a.nii"))->info().voxel_unit, "um");
  const std::string header = read_bytes(path("a.nii"));
  EXPECT_EQ(header.substr(252, 4), std::string("\1\0\1\0", 4)) << "qform_code, sform_code";
  volume.info().offset[0] = 1234567891;  // 1234567.891 um would become 1234567.875
  try {
    write_volume(path("a.nii"), MemorySource(volume));
    ADD_FAILURE() << "the offset was moved";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("offset"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("1234567.8"), std::string::npos) << error.what();
  }
  EXPECT_EQ(read_bytes(path("a.nii")), header);
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
