// HDF5: axis order, the choice of dataset, kinds and steps, against files made with the C library directly.
#include <hdf5.h>

#include "io_fixture.hpp"

namespace cvr::volumes {
namespace {

/// An HDF5 file made by plain calls of the library, so that no code under test writes it.
class Hdf5File {
 public:
  explicit Hdf5File(std::string name)
      : name_(std::move(name)), file_(H5Fcreate(name_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)) {}
  ~Hdf5File() { close(); }

  template <class T>
  Hdf5File& dataset(const char* name, hid_t type, const std::vector<hsize_t>& size,
                    const std::vector<T>& values) {
    const hid_t space = H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
    const hid_t data = H5Dcreate2(file_, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t memory = H5Tget_native_type(type, H5T_DIR_DEFAULT);
    if (!values.empty()) H5Dwrite(data, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Tclose(memory);
    H5Dclose(data);
    H5Sclose(space);
    return *this;
  }

  Hdf5File& numbers(const char* object, const char* name, const std::vector<double>& values) {
    const hsize_t count = values.size();
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t attribute = H5Acreate_by_name(file_, object, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                                              H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_DOUBLE, values.data());
    H5Aclose(attribute);
    H5Sclose(space);
    return *this;
  }

  Hdf5File& fixed_text(const char* object, const char* name, const std::string& text) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, text.size());  // without room for a terminator
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute =
        H5Acreate_by_name(file_, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, text.data());
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
    return *this;
  }

  const std::string& close() {
    if (file_ >= 0) H5Fclose(std::exchange(file_, -1));
    return name_;
  }

 private:
  std::string name_;
  hid_t file_;
};

template <class T>
std::vector<T> counting(std::size_t count) {
  std::vector<T> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<T>(i);
  return values;
}

using Hdf5 = IoTest;

TEST_F(Hdf5, TheLastAxisOfTheFileIsX) {
  // z = 2, y = 3, x = 4, written in C order: the fifth value is (0, 1, 0).
  const std::string name = Hdf5File(path("a.h5"))
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
  expect_error(name + ":/odd", {"attribute 'kind'", "colours"});
  expect_error(name, {"/hounsfield, /labels, /odd, /scalars, /stated, /volume"});
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
  expect_error(name + ":/bad", {"-7"}, VolumeKind::kLabels);
}

TEST_F(Hdf5, SeriesAreStacksOfSteps) {
  const std::string name =
      Hdf5File(path("a.h5")).dataset("scalars", H5T_IEEE_F32LE, {3, 2, 3, 4}, counting<float>(72)).close();
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

TEST_F(Hdf5, RefusesOtherRanksTypesAndAttributes) {
  Hdf5File file(path("a.h5"));
  file.dataset("flat", H5T_STD_U8LE, {3, 4}, counting<std::uint8_t>(12));
  file.dataset("double", H5T_IEEE_F64LE, {1, 1, 1}, counting<double>(1));
  file.dataset("int", H5T_STD_I32LE, {1, 1, 1}, counting<std::int32_t>(1));
  file.dataset("wide", H5T_STD_U32LE, {1, 1, 1}, counting<std::uint32_t>(1));
  file.dataset("empty", H5T_STD_U8LE, {0, 2, 2}, std::vector<std::uint8_t>{});
  file.dataset("two", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1))
      .numbers("two", "voxel_size", {1, 2});
  file.dataset("zero", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1))
      .numbers("zero", "voxel_size", {1, 0, 2});
  file.dataset("series", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1));
  const std::string name = file.close();
  expect_error(name + ":/flat", {"rank 2"});
  expect_error(name + ":/double", {"f64"});
  expect_error(name + ":/int", {"i32"});
  expect_error(name + ":/wide", {"u32", "scalars"}, VolumeKind::kScalars);
  expect_error(name + ":/empty", {"2x2x0"});
  expect_error(name + ":/two", {"voxel_size"});
  expect_error(name + ":/zero", {"voxel_size"});
  expect_error(name + ":/series[0]", {"single volume", "[0]"});
}

TEST_F(Hdf5, AbsurdExtentsAreRefusedBeforeAnyAllocation) {
  const hid_t file = H5Fcreate(path("a.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
  const std::array<hsize_t, 3> chunk{4, 4, 4}, size{hsize_t{1} << 20, hsize_t{1} << 20, hsize_t{1} << 20};
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
  for (const std::size_t length : {bytes.size() - 1, bytes.size() / 2, std::size_t{600}, std::size_t{8}}) {
    EXPECT_THROW(read_all(*open_volume(write_bytes("cut.h5", bytes.substr(0, length)))), InputError)
        << length;
  }
}

TEST_F(Hdf5, ChunksLargerThanTheDatasetAreRefused) {
  const Volume volume = patterned({5, 4, 3}, VoxelType::kU32, VolumeKind::kLabels);
  write_volume(path("a.h5"), MemorySource(volume));
  std::string bytes = read_bytes(path("a.h5"));
  const std::size_t chunk =
      bytes.find(std::string("\3\0\0\0\4\0\0\0\5\0\0\0\4\0\0\0", 16));  // z, y, x, bytes a voxel
  ASSERT_NE(chunk, std::string::npos);
  bytes[chunk + 6] = '\x80';
  expect_error(write_bytes("b.h5", bytes), {"chunks no larger than the dataset", "3x8388612x5 of 3x4x5"});
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
