// HDF5: axis order, the choice of dataset, kinds and steps, against files made with the C library
// directly.
#include "tests/unit/volumes/io/hdf5_file.hpp"

namespace cvr::volumes {
namespace {

using Hdf5 = IoTest;

TEST_F(Hdf5, TheLastAxisOfTheFileIsX) {
  // z = 2, y = 3, x = 4, written in C order: the fifth value is (0, 1, 0).
  const std::string name =
      Hdf5File(path("a.h5"))
          .dataset("labels", H5T_STD_U16BE, {2, 3, 4}, counting<std::uint16_t>(24))
          .numbers("labels", "voxel_size", {40, 8, 4})
          .close();
  const auto source = open_volume(name);
  EXPECT_EQ(source->info().extent, (Extent{4, 3, 2}));
  EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{4, 8, 40}));
  const Volume volume = read_all(*source);
  EXPECT_EQ(volume.label({1, 0, 0}), 1u);
  EXPECT_EQ(volume.label({0, 1, 0}), 4u);
  EXPECT_EQ(volume.label({0, 0, 1}), 12u);
  expect_boxes(*source, volume);
}

TEST_F(Hdf5, KindComesFromHintAttributeNameAndType) {
  Hdf5File file(path("a.h5"));
  file.dataset("labels", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1));
  file.dataset("scalars", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1));
  file.dataset("volume", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1));
  file.dataset("stated", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1))
      .fixed_text("stated", "kind", "scalars");
  file.dataset("hounsfield", H5T_STD_I16LE, {1, 1, 1}, counting<std::int16_t>(1));
  file.dataset("odd", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1))
      .fixed_text("odd", "kind", "colours");
  const std::string name = file.close();
  EXPECT_EQ(open_volume(name + ":/labels")->info().kind, VolumeKind::kLabels);
  EXPECT_EQ(open_volume(name + ":/scalars")->info().kind, VolumeKind::kScalars);
  EXPECT_EQ(open_volume(name + ":/volume")->info().kind, VolumeKind::kLabels);
  EXPECT_EQ(open_volume(name + ":/stated")->info().kind, VolumeKind::kScalars);
  EXPECT_EQ(open_volume(name + ":/hounsfield")->info().kind, VolumeKind::kScalars);
  EXPECT_EQ(open_volume(name + ":/stated", VolumeKind::kLabels)->info().kind, VolumeKind::kLabels);
  EXPECT_EQ(open_volume(name + ":/odd")->info().kind,
            VolumeKind::kLabels);  // somebody else's attribute
  expect_error(name, {"/hounsfield (rank 3, 1x1x1, i16)", "/labels (rank 3, 1x1x1, u8)", "/odd",
                      "/scalars"});
  expect_error(name + ":/none", {"'/none'", "/labels"});
}

TEST_F(Hdf5, SignedLabelsAreCheckedNotWrapped) {
  Hdf5File file(path("a.h5"));
  file.dataset("good", H5T_STD_I16LE, {1, 1, 3}, std::vector<std::int16_t>{1, 32767, 0});
  file.dataset("bad", H5T_STD_I16LE, {1, 1, 3}, std::vector<std::int16_t>{-7, 2, 3});
  const std::string name = file.close();
  const Volume good = read_all(*open_volume(name + ":/good", VolumeKind::kLabels));
  EXPECT_EQ(good.info().type, VoxelType::kU16);
  EXPECT_EQ(good.label({1, 0, 0}), 32767u);
  expect_error(name + ":/bad", {"-7", "voxel (0, 0, 0)"}, VolumeKind::kLabels);
}

TEST_F(Hdf5, BoxesAreReadInPartsOfWholeChunks) {
  const Extent e{310, 201, 150};  // 37 MB, more than is read at once
  std::vector<std::uint32_t> labels(e.voxels());
  for (std::size_t i = 0; i < labels.size(); ++i)
    labels[i] = static_cast<std::uint32_t>(i) * 0x9e3779b1u;
  const std::vector<Box> boxes{{{0, 0, 0}, e},
                               {{63, 49, 6}, {2, 2, 2}},
                               {{1, 0, 3}, {309, 201, 147}},
                               {{309, 200, 149}, {1, 1, 1}}};
  for (const std::vector<hsize_t>& chunk : std::vector<std::vector<hsize_t>>{
           {}, {7, 50, 64}, {150, 1, 310}, {1, 201, 310}, {150, 201, 310}}) {
    const std::string name =
        Hdf5File(path("v.h5"))
            .dataset("labels", H5T_NATIVE_UINT32, {e.z, e.y, e.x}, labels, chunk)
            .close();
    const auto source = open_volume(name);
    ASSERT_EQ(source->info().extent, e);
    for (const Box& box : boxes) {
      std::vector<std::uint32_t> found(box.size.voxels());
      source->read(box, reinterpret_cast<std::byte*>(found.data()));
      std::size_t differing = 0;
      for (std::uint64_t i = 0; i < found.size(); ++i) {
        const Coordinate at{box.origin.x + i % box.size.x,
                            box.origin.y + i / box.size.x % box.size.y,
                            box.origin.z + i / box.size.x / box.size.y};
        differing += found[i] != labels[e.index(at)];
      }
      EXPECT_EQ(differing, 0u) << testing::PrintToString(chunk) << " " << to_string(box.size);
    }
  }
}

TEST_F(Hdf5, SeriesAreStacksOfSteps) {
  const std::string name =
      Hdf5File(path("a.h5"))
          .dataset("scalars", H5T_IEEE_F32LE, {3, 2, 3, 4}, counting<float>(72))
          .close();
  for (const char* step : {":/scalars[2]", "[2]"}) {
    const auto source = open_volume(name + step);
    EXPECT_EQ(source->info().extent, (Extent{4, 3, 2}));
    const Volume volume = read_all(*source);
    EXPECT_EQ(volume.voxels<float>()[5], 53.0f);
    expect_boxes(*source, volume);
  }
  const auto whole = open_volume(name), later = open_volume(name + "[1:3]");
  EXPECT_EQ(whole->info().extent, (Extent{4, 3, 6}));
  EXPECT_EQ(whole->info().time_steps, 3u);
  const Volume all = read_all(*whole);
  for (std::size_t i = 0; i < 72; ++i) ASSERT_EQ(all.voxels<float>()[i], static_cast<float>(i));
  expect_boxes(*whole, all);
  EXPECT_EQ(later->info().time_steps, 2u);
  EXPECT_EQ(read_all(*later).voxels<float>()[0], 24.0f);
  expect_error(name + ":/scalars[3]", {"from 0 to 2", "[3]"});
  expect_error(name + ":/scalars[2:4]", {"B <= 3", "[2:4]"});
  expect_error(name + "[2:1]", {"B <= 3", "[2:1]"});
}

TEST_F(Hdf5, RefusesOtherRanksAndTypes) {
  Hdf5File file(path("a.h5"));
  file.dataset("line", H5T_STD_U8LE, {12}, counting<std::uint8_t>(12));
  file.dataset("double", H5T_IEEE_F64LE, {1, 1, 1}, counting<double>(1));
  file.dataset("wide", H5T_STD_U32LE, {1, 1, 1}, counting<std::uint32_t>(1));
  file.dataset("empty", H5T_STD_U8LE, {0, 2, 2}, std::vector<std::uint8_t>{});
  file.dataset("single", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1));
  const std::string name = file.close();
  expect_error(name + ":/line", {"rank 1"});
  expect_error(name + ":/double", {"f64", "float64", "--kind labels", "float32"});
  expect_error(name + ":/wide", {"u32", "scalars"}, VolumeKind::kScalars);
  expect_error(name + ":/empty", {"2x2x0"});
  expect_error(name + ":/single[0]", {"single volume", "[0]"});
}

TEST_F(Hdf5, AbsurdExtentsAreRefusedBeforeAnyAllocation) {
  const hid_t file = H5Fcreate(path("a.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
  const std::array<hsize_t, 3> chunk{4, 4, 4},
      size{hsize_t{1} << 20, hsize_t{1} << 20, hsize_t{1} << 20};
  H5Pset_chunk(layout, 3, chunk.data());
  const hid_t space = H5Screate_simple(3, size.data(), nullptr);
  H5Dclose(H5Dcreate2(file, "labels", H5T_STD_U8LE, space, H5P_DEFAULT, layout, H5P_DEFAULT));
  H5Sclose(space);
  H5Pclose(layout);
  H5Fclose(file);
  expect_error(path("a.h5"), {"1048576x1048576x1048576"});
}

TEST_F(Hdf5, DamagedFilesAreErrors) {
  const Volume volume = patterned({70, 13, 67}, VoxelType::kU32, VolumeKind::kLabels);
  write_volume(path("a.h5"), MemorySource(volume));
  const std::string bytes = read_bytes(path("a.h5"));
  for (const std::size_t length :
       {bytes.size() - 1, bytes.size() / 2, std::size_t{600}, std::size_t{8}}) {
    EXPECT_THROW(read_all(*open_volume(write_bytes("cut.h5", bytes.substr(0, length)))), InputError)
        << length;
  }
}

TEST_F(Hdf5, ChunksLargerThanTheDatasetAreRefused) {
  const Volume volume = patterned({5, 4, 3}, VoxelType::kU32, VolumeKind::kLabels);
  write_volume(path("a.h5"), MemorySource(volume));
  std::string bytes = read_bytes(path("a.h5"));
  const std::size_t chunk =
      bytes.find(std::string("\3\0\0\0\4\0\0\0\5\0\0\0\4\0\0\0", 16));  // z, y, x, bytes per voxel
  ASSERT_NE(chunk, std::string::npos);
  bytes[chunk + 6] = '\x80';
  expect_error(write_bytes("b.h5", bytes),
               {"chunks no larger than the dataset", "3x8388612x5 of 3x4x5"});
}

TEST_F(Hdf5, WritesIntoTheDatasetThatTheNameSays) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU8, VolumeKind::kScalars);
  write_volume(path("a.h5") + ":/group/volume", MemorySource(volume));
  const auto source = open_volume(path("a.h5") + ":/group/volume");
  EXPECT_EQ(source->info().kind, VolumeKind::kScalars);
  expect_boxes(*source, volume);
}

}  // namespace
}  // namespace cvr::volumes
