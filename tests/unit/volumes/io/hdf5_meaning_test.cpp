// HDF5: what files say of their axes, types, voxel sizes and offsets, and what is somebody else's.
#include <limits>

#include "tests/unit/volumes/io/hdf5_file.hpp"

namespace cvr::volumes {
namespace {

using Hdf5Axes = IoTest;
using Hdf5Types = IoTest;
using Hdf5Attribute = IoTest;

OpenOptions axes(const std::string& letters) {
  OpenOptions options;
  options.axes = letters;
  return options;
}

std::string axistags(const std::string& keys, const std::vector<double>& resolutions) {
  std::string text = R"({"axes": [)";
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i > 0) text += ',';
    text += R"({"key": ")";
    text += keys[i];
    text += R"(", "typeFlags": 2, "description": "", "resolution": )";
    text += std::to_string(resolutions[i]);
    text += '}';
  }
  return text + "]}";
}

/// Opening must throw an InputError that says all of `parts`.
void expect_refused(const std::string& name, const OpenOptions& options,
                    const std::vector<std::string>& parts) {
  try {
    open_volume(name, options);
    ADD_FAILURE() << name << " was opened";
  } catch (const InputError& error) {
    for (const std::string& part : parts)
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
          << error.what() << " lacks " << part;
  }
}

TEST_F(Hdf5Axes, AxistagsTransposeWithinBoxes) {
  // x = 3, y = 4, z = 5 with x slowest: the voxel (x, y, z) is 20 x + 5 y + z.
  const std::string name =
      Hdf5File(path("a.h5"))
          .dataset("data", H5T_STD_U16LE, {3, 4, 5}, counting<std::uint16_t>(60))
          .text("data", "axistags", axistags("xyz", {0.3, 0.4, 1.1}))
          .close();
  const auto source = open_volume(name);
  EXPECT_EQ(source->info().extent, (Extent{3, 4, 5}));
  EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{0.3, 0.4, 1.1}));
  const Volume volume = read_all(*source);
  for (std::uint64_t x = 0; x < 3; ++x) {
    for (std::uint64_t y = 0; y < 4; ++y) {
      for (std::uint64_t z = 0; z < 5; ++z) ASSERT_EQ(volume.label({x, y, z}), 20 * x + 5 * y + z);
    }
  }
  expect_boxes(*source, volume);
  EXPECT_EQ(read_all(*open_volume(name, axes("zyx"))).label({1, 0, 0}),
            1u);  // the caller goes before the file
}

TEST_F(Hdf5Axes, LargeTransposedVolumesAreReadInParts) {
  // 150 x 260 x 300 voxels of 4 bytes are more than the memory that is shared with the reading
  // process.
  constexpr std::uint64_t kX = 150, kY = 260, kZ = 300;
  std::vector<std::uint32_t> values(kX * kY * kZ);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<std::uint32_t>(i * 2654435761u);
  const std::string name = Hdf5File(path("a.h5"))
                               .dataset("data", H5T_STD_U32LE, {kY, kX, kZ}, values)
                               .fixed_text("data", "axes", "yxz")
                               .close();
  const Volume volume = read_all(*open_volume(name));
  ASSERT_EQ(volume.extent(), (Extent{kX, kY, kZ}));
  std::uint64_t wrong = 0;
  for (std::uint64_t z = 0; z < kZ; ++z) {
    for (std::uint64_t y = 0; y < kY; ++y) {
      for (std::uint64_t x = 0; x < kX; ++x)
        wrong += volume.label({x, y, z}) != values[(y * kX + x) * kZ + z];
    }
  }
  EXPECT_EQ(wrong, 0u);
}

TEST_F(Hdf5Axes, AxesOfLengthOneAreDropped) {
  const std::string name =
      Hdf5File(path("a.h5"))
          .dataset("data", H5T_STD_U8LE, {1, 2, 3, 4, 1}, counting<std::uint8_t>(24))
          .text("data", "axistags", axistags("tzyxc", {0, 0, 0, 0, 0}))
          .close();
  const auto source = open_volume(name);
  EXPECT_EQ(source->info().extent, (Extent{4, 3, 2}));
  EXPECT_EQ(source->info().time_steps, 1u);
  EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{1, 1, 1}));
  EXPECT_EQ(read_all(*source).label({1, 2, 1}), 21u);
}

TEST_F(Hdf5Axes, TimeMayBeTheFastestAxis) {
  const std::string name =
      Hdf5File(path("a.h5"))
          .dataset("data", H5T_STD_U8LE, {2, 3, 4, 5}, counting<std::uint8_t>(120))
          .texts("data", "DIMENSION_LABELS", {"z", "y", "x", "time"})
          .close();
  const auto source = open_volume(name);
  EXPECT_EQ(source->info().time_steps, 5u);
  EXPECT_EQ(source->info().extent, (Extent{4, 3, 10}));
  const Volume volume = read_all(*source);
  EXPECT_EQ(volume.label({1, 2, 1 + 2 * 4}), 5u * (1 + 4 * (2 + 3 * 1)) + 4);
  expect_boxes(*source, volume);
  EXPECT_EQ(read_all(*open_volume(name + "[3]")).label({0, 0, 0}), 3u);
}

TEST_F(Hdf5Axes, PlanesAreVolumesOfOnePlane) {
  const std::string name = Hdf5File(path("a.h5"))
                               .dataset("data", H5T_STD_U8LE, {3, 4}, counting<std::uint8_t>(12))
                               .close();
  const auto source = open_volume(name + ":/data");
  EXPECT_EQ(source->info().extent, (Extent{4, 3, 1}));
  EXPECT_EQ(read_all(*source).label({1, 2, 0}), 9u);
  expect_error(name, {"/data (rank 2, 3x4, u8)"});  // taken only when it is named
}

TEST_F(Hdf5Axes, WhatIsAmbiguousAsksForAxes) {
  Hdf5File file(path("a.h5"));
  file.dataset("last", H5T_STD_U8LE, {2, 5, 6, 3}, counting<std::uint8_t>(180));
  file.dataset("one", H5T_STD_U8LE, {5, 6, 7, 1}, counting<std::uint8_t>(210));
  file.dataset("five", H5T_STD_U8LE, {1, 2, 3, 4, 1}, counting<std::uint8_t>(24));
  file.dataset("twice", H5T_STD_U8LE, {2, 3, 4}, counting<std::uint8_t>(24))
      .fixed_text("twice", "axes", "zzy");
  file.dataset("short", H5T_STD_U8LE, {2, 3, 4}, counting<std::uint8_t>(24))
      .texts("short", "axes", {"z", "y"});
  file.dataset("odd", H5T_STD_U8LE, {2, 3, 4}, counting<std::uint8_t>(24))
      .text("odd", "axistags", "{]");
  file.dataset("other", H5T_STD_U8LE, {2, 3, 4}, counting<std::uint8_t>(24))
      .fixed_text("other", "axes", "none");
  const std::string name = file.close();
  for (const char* dataset : {":/last", ":/one", ":/five", ":/twice", ":/short", ":/odd"}) {
    SCOPED_TRACE(dataset);
    expect_refused(name + dataset, {}, {"--axes", "axes"});
  }
  EXPECT_EQ(open_volume(name + ":/one", axes("zyxc"))->info().extent, (Extent{7, 6, 5}));
  EXPECT_EQ(open_volume(name + ":/last", axes("tzyx"))->info().extent, (Extent{3, 6, 10}));
  EXPECT_EQ(open_volume(name + ":/five", axes("CZYXT"))->info().extent, (Extent{4, 3, 2}));
  EXPECT_EQ(open_volume(name + ":/other")->info().extent,
            (Extent{4, 3, 2}));  // says nothing of x, y, z
  expect_refused(name + ":/last", axes("zyxc"), {"3 channels", "h5py"});
  expect_refused(name + ":/last", axes("zyx"), {"4 letters", "'zyx'"});
  expect_refused(name + ":/last", axes("qzyx"), {"t z y x c"});
  expect_refused(name + ":/last", axes("zzyx"), {"twice"});
}

TEST_F(Hdf5Axes, OwnSeriesSayTheirAxes) {
  Volume volume = patterned({3, 9, 10}, VoxelType::kU8, VolumeKind::kLabels);
  volume.info().time_steps = 2;
  write_volume(path("a.h5"), MemorySource(volume));
  const auto source = open_volume(path("a.h5"));
  EXPECT_EQ(source->info().time_steps, 2u);
  expect_boxes(*source, volume);
}

TEST_F(Hdf5Types, SignedIntegersAreLabels) {
  Hdf5File file(path("a.h5"));
  file.dataset("i8", H5T_STD_I8LE, {1, 2, 3}, std::vector<std::int8_t>{0, 1, 2, 3, 4, 127});
  file.dataset("i32", H5T_STD_I32BE, {1, 2, 3},
               std::vector<std::int32_t>{0, 1, 2, 3, 4, 2147483647});
  file.dataset("i64", H5T_STD_I64LE, {1, 2, 3},
               std::vector<std::int64_t>{0, 1, 2, 3, 4, std::int64_t{1} << 62});
  file.dataset("bad", H5T_STD_I64LE, {1, 2, 3}, std::vector<std::int64_t>{0, 1, 2, 3, -4, 5});
  const std::string name = file.close();
  const auto last = [&](const char* dataset, VoxelType type) {
    const Volume volume = read_all(*open_volume(name + ":/" + dataset));
    EXPECT_EQ(volume.info().type, type);
    return volume.label({2, 1, 0});
  };
  EXPECT_EQ(last("i8", VoxelType::kU8), 127u);
  EXPECT_EQ(last("i32", VoxelType::kU32), 2147483647u);
  EXPECT_EQ(last("i64", VoxelType::kU64), std::uint64_t{1} << 62);
  try {
    read_all(*open_volume(name + ":/bad"));
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("-4 at voxel (1, 1, 0)"), std::string::npos)
        << error.what();
  }
}

TEST_F(Hdf5Types, WholeNumbersInFloatingPointAreLabelsWhenSaid) {
  const float far = std::numeric_limits<float>::quiet_NaN();
  Hdf5File file(path("a.h5"));
  file.dataset("f32", H5T_IEEE_F32BE, {1, 1, 3}, std::vector<float>{0, 16777216, 7});
  file.dataset("f64", H5T_IEEE_F64LE, {1, 1, 3}, std::vector<double>{0, 9007199254740992.0, 7});
  file.dataset("half", H5T_IEEE_F32LE, {1, 1, 3}, std::vector<float>{1, 0.5f, 7});
  file.dataset("large", H5T_IEEE_F32LE, {1, 1, 3}, std::vector<float>{1, 16777218, 7});
  file.dataset("below", H5T_IEEE_F64LE, {1, 1, 3}, std::vector<double>{1, -1, 7});
  file.dataset("none", H5T_IEEE_F32LE, {1, 1, 3}, std::vector<float>{1, far, 7});
  file.dataset("labels", H5T_IEEE_F32LE, {1, 1, 3}, std::vector<float>{1, 2, 7});
  const std::string name = file.close();
  const Volume f32 = read_all(*open_volume(name + ":/f32", VolumeKind::kLabels));
  EXPECT_EQ(f32.info().type, VoxelType::kU32);
  EXPECT_EQ(f32.label({1, 0, 0}), 16777216u);
  const Volume f64 = read_all(*open_volume(name + ":/f64", VolumeKind::kLabels));
  EXPECT_EQ(f64.info().type, VoxelType::kU64);
  EXPECT_EQ(f64.label({1, 0, 0}), 9007199254740992u);
  EXPECT_EQ(open_volume(name + ":/f32")->info().type, VoxelType::kF32);
  EXPECT_EQ(open_volume(name + ":/labels")->info().type, VoxelType::kU32);  // its name says so
  for (const auto& [dataset, value] :
       {std::pair{"half", "0.5"}, {"large", "16777218"}, {"below", "-1"}, {"none", "nan"}}) {
    try {
      read_all(*open_volume(name + ":/" + dataset, VolumeKind::kLabels));
      ADD_FAILURE() << dataset;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(std::string(value) + " at voxel (1, 0, 0)"),
                std::string::npos)
          << error.what();
    }
  }
}

TEST_F(Hdf5Types, TruthValuesAndFillValuesAreRead) {
  Hdf5File file(path("a.h5"));
  const hid_t truth = H5Tenum_create(H5T_NATIVE_INT8);
  const std::int8_t no = 0, yes = 1;
  H5Tenum_insert(truth, "FALSE", &no);
  H5Tenum_insert(truth, "TRUE", &yes);
  file.dataset("mask", truth, {1, 1, 3}, std::vector<std::int8_t>{0, 1, 1});
  H5Tclose(truth);
  const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
  const std::array<hsize_t, 3> chunk{2, 2, 2}, size{5, 4, 3};
  const std::uint32_t fill = 9;
  H5Pset_chunk(layout, 3, chunk.data());
  H5Pset_fill_value(layout, H5T_NATIVE_UINT32, &fill);
  const hid_t space = H5Screate_simple(3, size.data(), nullptr);
  H5Dclose(H5Dcreate2(file.id(), "fill", H5T_STD_U32LE, space, H5P_DEFAULT, layout, H5P_DEFAULT));
  H5Sclose(space);
  H5Pclose(layout);
  const std::string name = file.close();
  const Volume mask = read_all(*open_volume(name + ":/mask"));
  EXPECT_EQ(mask.info().type, VoxelType::kU8);
  EXPECT_EQ(mask.label({1, 0, 0}), 1u);
  EXPECT_EQ(read_all(*open_volume(name + ":/fill")).label({2, 3, 4}), 9u);
}

TEST_F(Hdf5Types, OtherTypesAreNamed) {
  Hdf5File file(path("a.h5"));
  const hid_t colour = H5Tcreate(H5T_COMPOUND, 2);
  H5Tinsert(colour, "r", 0, H5T_NATIVE_UINT8);
  H5Tinsert(colour, "g", 1, H5T_NATIVE_UINT8);
  const std::array<hsize_t, 3> size{1, 1, 1};
  const hid_t space = H5Screate_simple(3, size.data(), nullptr);
  H5Dclose(H5Dcreate2(file.id(), "colour", colour, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Sclose(space);
  H5Tclose(colour);
  const std::string name = file.close();
  expect_error(name + ":/colour", {"compound of r, g"});
  expect_error(name, {"exactly one volume", "/colour (rank 3, 1x1x1, a compound of r, g)"});
}

TEST_F(Hdf5Attribute, CremiPlantSegAndFijiAreObeyed) {
  Hdf5File file(path("a.h5"));
  for (const char* dataset : {"cremi", "fiji", "by_axis", "ours"})
    file.dataset(dataset, H5T_STD_U8LE, {2, 3, 4}, counting<std::uint8_t>(24));
  file.numbers("cremi", "resolution", {40, 4, 8}).numbers("cremi", "offset", {1480, 3644, 12});
  file.numbers("fiji", "element_size_um", {0.235, 0.15, 0.1});
  file.dataset("series", H5T_STD_U8LE, {2, 2, 3, 9}, counting<std::uint8_t>(108));
  file.numbers("series", "element_size_um", {1, 3, 4, 5}).fixed_text("series", "axes", "tzyx");
  file.numbers("ours", "voxel_size", {3, 2, 1})
      .numbers("ours", "resolution", {40, 4, 4})
      .text("ours", "voxel_unit", "mm");
  const std::string name = file.close();
  using Triple = std::array<double, 3>;
  const VolumeInfo cremi = open_volume(name + ":/cremi")->info();
  EXPECT_EQ(cremi.voxel_size, (Triple{8, 4, 40}));
  EXPECT_EQ(cremi.offset, (Triple{12, 3644, 1480}));
  EXPECT_EQ(cremi.voxel_unit, "nm");
  const VolumeInfo fiji = open_volume(name + ":/fiji")->info();
  EXPECT_EQ(fiji.voxel_size, (Triple{0.1, 0.15, 0.235}));
  EXPECT_EQ(fiji.voxel_unit, "um");
  EXPECT_EQ(open_volume(name + ":/series")->info().voxel_size, (Triple{5, 4, 3}));
  EXPECT_EQ(open_volume(name + ":/ours")->info().voxel_size, (Triple{1, 2, 3}));
  EXPECT_EQ(open_volume(name + ":/ours")->info().voxel_unit, "mm");
}

TEST_F(Hdf5Attribute, SomebodyElsesNeverMakeAFileUnreadable) {
  Hdf5File file(path("a.h5"));
  file.dataset("data", H5T_STD_U8LE, {2, 3, 4}, counting<std::uint8_t>(24));
  for (const char* name : {"kind", "name", "source", "licence", "voxel_unit"})
    file.numbers("data", name, {1, 2});
  file.numbers("data", "voxel_size", {1, 0, 2})
      .numbers("data", "offset", {5})
      .numbers("data", "axes", {1, 2, 3});
  file.numbers("data", "resolution", {300, 300}).text("data", "element_size_um", "1 2 3");
  file.dataset("texts", H5T_STD_U8LE, {2, 3, 4}, counting<std::uint8_t>(24));
  file.text("texts", "kind", "colours")
      .texts("texts", "name", {"a", "b"})
      .text("texts", "voxel_size", "4x4x40");
  file.text("texts", "source", "two\nlines").text("texts", "licence", "\xff\xfe");
  const std::string name = file.close();
  for (const char* dataset : {":/data", ":/texts"}) {
    const auto source = open_volume(name + dataset);
    EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{1, 1, 1}));
    EXPECT_EQ(source->info().offset, (std::array<double, 3>{0, 0, 0}));
    EXPECT_EQ(source->info().kind, VolumeKind::kLabels);
    EXPECT_EQ(read_all(*source).label({3, 2, 1}), 23u);
  }
  EXPECT_EQ(open_volume(name + ":/texts")->provenance(), (Provenance{"", "two\nlines", ""}));
}

TEST_F(Hdf5Attribute, OffsetSizeAndUnitComeBack) {
  Volume volume = patterned({5, 4, 3}, VoxelType::kU16, VolumeKind::kLabels);
  volume.info().offset = {-3.5, 7, 1e6};
  write_volume(path("a.h5"), MemorySource(volume));
  const VolumeInfo info = open_volume(path("a.h5"))->info();
  EXPECT_EQ(info.offset, volume.info().offset);
  EXPECT_EQ(info.voxel_size, volume.info().voxel_size);
  EXPECT_EQ(info.voxel_unit, "nm");
}

}  // namespace
}  // namespace cvr::volumes
