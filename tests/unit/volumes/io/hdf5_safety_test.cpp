// HDF5: files that name other files, files that are damaged, and filters that are not there.
// Nothing of these ends or hangs this process, and no process is left behind.
#include <dirent.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "tests/unit/volumes/io/hdf5_file.hpp"

namespace cvr::volumes {
namespace {

class Hdf5Safety : public IoTest {
 protected:
  void TearDown() override {
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a process was left behind";
    EXPECT_EQ(errno, ECHILD);
    IoTest::TearDown();
  }

  /// A file `name` whose dataset `data` of 2x3x4 u8 lies in the file `raw`.
  std::string external(const std::string& name, const std::string& raw, off_t offset = 0) const {
    Hdf5File file(path(name));
    const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_external(layout, raw.c_str(), offset, 24);
    make(file, layout);
    return file.close();
  }

  /// A virtual dataset over `dataset` of `source`.
  std::string virtual_file(const std::string& name, const std::string& source,
                           const std::string& dataset) const {
    Hdf5File file(path(name));
    const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
    const std::array<hsize_t, 3> size{2, 3, 4};
    const hid_t space = H5Screate_simple(3, size.data(), nullptr);
    H5Pset_virtual(layout, space, source.c_str(), dataset.c_str(), space);
    H5Sclose(space);
    make(file, layout);
    return file.close();
  }

  std::string source_file(const std::string& name) const {
    std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
    return Hdf5File(path(name))
        .dataset("x", H5T_STD_U8LE, {2, 3, 4}, counting<std::uint8_t>(24))
        .close();
  }

  void expect_counting(const std::string& name, bool allow_external) const {
    OpenOptions options;
    options.allow_external = allow_external;
    const Volume volume = read_all(*open_volume(name, options));
    ASSERT_EQ(volume.extent(), (Extent{4, 3, 2})) << name;
    for (std::size_t i = 0; i < 24; ++i) ASSERT_EQ(volume.voxels<std::uint8_t>()[i], i) << name;
  }

 private:
  static void make(Hdf5File& file, hid_t layout) {
    const std::array<hsize_t, 3> size{2, 3, 4};
    const hid_t space = H5Screate_simple(3, size.data(), nullptr);
    H5Dclose(H5Dcreate2(file.id(), "data", H5T_STD_U8LE, space, H5P_DEFAULT, layout, H5P_DEFAULT));
    H5Sclose(space);
    H5Pclose(layout);
  }
};

std::string counting_bytes() {
  std::string bytes(24, '\0');
  for (int i = 0; i < 24; ++i) bytes[static_cast<std::size_t>(i)] = static_cast<char>(i);
  return bytes;
}

TEST_F(Hdf5Safety, ExternalStorageStaysInTheFolder) {
  write_bytes("in/raw.bin", counting_bytes());
  write_bytes("out.bin", counting_bytes());
  write_bytes("in/short.bin", counting_bytes().substr(0, 20));
  expect_counting(external("in/good.h5", "raw.bin"), false);
  EXPECT_EQ(open_volume(path("in/good.h5"))->files(),
            (std::vector<std::string>{path("in/good.h5"), path("in/raw.bin")}));
  expect_error(external("in/passwd.h5", "/etc/passwd"),
               {"'/etc/passwd'", "--allow-external", "allow_external"});
  const std::string up = external("in/up.h5", "../out.bin");
  expect_error(up, {"'../out.bin'", "--allow-external"});
  expect_counting(up, true);
  std::filesystem::create_symlink("../out.bin", path("in/link.bin"));
  expect_error(external("in/link.h5", "link.bin"), {"'link.bin'", "--allow-external"});
  expect_error(external("in/none.h5", "none.bin"), {"'none.bin'", "No such file"});
  expect_error(external("in/short.h5", "short.bin"),
               {"24 bytes", "20 bytes"});  // libhdf5 would give zeros
  ASSERT_EQ(::mkfifo(path("in/pipe.bin").c_str(), 0600), 0);
  expect_error(external("in/pipe.h5", "pipe.bin"), {"'pipe.bin'", "pipe"});
}

TEST_F(Hdf5Safety, VirtualSourcesMustBeThere) {
  source_file("in/x.h5");
  source_file("out/x.h5");
  Hdf5File(path("in/small.h5"))
      .dataset("x", H5T_STD_U8LE, {2, 3, 3}, counting<std::uint8_t>(18))
      .close();
  expect_counting(virtual_file("in/good.h5", "x.h5", "/x"), false);
  EXPECT_EQ(open_volume(path("in/good.h5"))->files(),
            (std::vector<std::string>{path("in/good.h5"), path("in/x.h5")}));
  expect_error(virtual_file("in/gone.h5", "gone-source.h5", "/x"),
               {"gone-source.h5", "No such file"});
  expect_error(virtual_file("in/other.h5", "x.h5", "/y"), {"'/y'", "/x (rank 3, 2x3x4, u8)"});
  expect_error(virtual_file("in/less.h5", "small.h5", "/x"), {"small.h5:/x", "24 voxels", "2x3x3"});
  expect_error(virtual_file("in/self.h5", ".", "/data"), {"circle"});
  const std::string outside = virtual_file("in/outside.h5", "../out/x.h5", "/x");
  expect_error(outside, {"../out/x.h5", "--allow-external"});
  expect_counting(outside, true);
  ASSERT_EQ(::mkfifo(path("in/pipe.h5").c_str(), 0600), 0);
  expect_error(virtual_file("in/pipe_user.h5", "pipe.h5", "/x"), {"pipe.h5", "pipe"});
}

TEST_F(Hdf5Safety, LinksAreLookedAtBeforeTheyAreFollowed) {
  source_file("in/x.h5");
  source_file("out/x.h5");
  ASSERT_EQ(::mkfifo(path("in/pipe.h5").c_str(), 0600), 0);
  Hdf5File file(path("in/links.h5"));
  file.dataset("x", H5T_STD_U8LE, {2, 3, 4}, counting<std::uint8_t>(24));
  H5Gclose(H5Gcreate2(file.id(), "g", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Lcreate_soft("/x", file.id(), "g/soft", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_soft("circle", file.id(), "circle", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_soft("/nothing", file.id(), "dangling", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_external("x.h5", "/x", file.id(), "beside", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_external("x.h5", "/", file.id(), "root", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_external("../out/x.h5", "/x", file.id(), "outside", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_external("pipe.h5", "/x", file.id(), "pipe", H5P_DEFAULT, H5P_DEFAULT);
  const std::string name = file.close();
  for (const char* good : {":/x", ":/g/soft", ":x", ":/beside", ":/root/x"})
    expect_counting(name + good, false);
  expect_counting(name, false);  // one dataset of its own
  EXPECT_EQ(open_volume(name + ":/beside")->files(),
            (std::vector<std::string>{name, path("in/x.h5")}));
  expect_error(name + ":/outside", {"../out/x.h5", "--allow-external"});
  expect_counting(name + ":/outside", true);
  expect_error(name + ":/circle", {"circle"});
  expect_error(name + ":/dangling", {"/dangling", "/x (rank 3"});
  expect_error(name + ":/pipe", {"pipe.h5", "pipe"});
  expect_error(name + ":/g", {"a group", "/x (rank 3"});
  expect_error(name + ":/none",
               {"'/none'", "/x (rank 3, 2x3x4, u8)", "external link '/beside' -> 'x.h5:/x'"});
}

TEST_F(Hdf5Safety, MissingFiltersAreNamed) {
  // A gzipped file whose filter is given other numbers in its header.
  const Volume volume = patterned({5, 4, 3}, VoxelType::kU32, VolumeKind::kLabels);
  write_volume(path("a.h5"), MemorySource(volume));
  const std::string bytes = read_bytes(path("a.h5"));
  const std::size_t at = bytes.find("deflate");
  ASSERT_NE(at, std::string::npos);
  // Before the name: filter (2 bytes), length of the name, flags, number of values (2 bytes each).
  for (const auto& [number, text] : {std::pair{32000, "lzf (filter 32000)"},
                                     {32001, "blosc (filter 32001)"},
                                     {32026, "blosc2 (filter 32026)"},
                                     {32008, "bitshuffle (filter 32008)"},
                                     {32015, "zstd (filter 32015)"},
                                     {31999, "filter 31999"}}) {
    std::string other = bytes;
    other[at - 8] = static_cast<char>(number & 0xff);
    other[at - 7] = static_cast<char>(number >> 8);
    expect_error(write_bytes("b.h5", other), {text, "plugin", "h5py"});
  }
}

/// A small file with texts of variable length, as other writers make them.
std::string damageable(const std::string& name) {
  Hdf5File file(name);
  file.dataset("labels", H5T_STD_U16LE, {5, 6, 7}, counting<std::uint16_t>(210));
  file.numbers("labels", "voxel_size", {40, 8, 4})
      .text("labels", "kind", "labels")
      .text("labels", "name", "cells");
  file.text("labels", "voxel_unit", "nm")
      .text("/", "source", "somewhere")
      .text("/", "licence", "CC0");
  return file.close();
}

/// Reads the whole volume: any answer is right but the end or a hang of this process, or another
/// exception.
void read_damaged(const std::string& name) {
  try {
    const auto source = open_volume(name);
    if (source->info().bytes() < 1 << 20) read_all(*source);
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("expected"), std::string::npos) << error.what();
  }
}

TEST_F(Hdf5Safety, DamagedTextsOfVariableLengthNeitherCrashNorHang) {
  const std::string bytes = read_bytes(damageable(path("a.h5")));
  const std::size_t heap =
      bytes.find("GCOL");  // the texts: version, 3 bytes, size of the heap, objects
  ASSERT_NE(heap, std::string::npos);
  std::vector<std::pair<std::size_t, char>> damages;
  for (std::size_t i = 0; i < 64; ++i)
    damages.emplace_back(heap + 4 + i, static_cast<char>(i % 2 == 0 ? 0x0a : 0xff));
  for (std::size_t i = 16; i < 48; i += 8) damages.emplace_back(heap + i, '\0');
  for (const auto& [at, value] : damages) {
    std::string damaged = bytes;
    damaged[at] = damaged[at] == value ? '\x33' : value;
    SCOPED_TRACE(at);
    read_damaged(write_bytes("b.h5", damaged));
  }
}

TEST_F(Hdf5Safety, FlippedBytesAreReadOrRefused) {
  const Volume volume = patterned({20, 17, 13}, VoxelType::kU32, VolumeKind::kLabels);
  write_volume(path("own.h5"), MemorySource(volume));
  for (const std::string& name : {path("own.h5"), damageable(path("other.h5"))}) {
    const std::string bytes = read_bytes(name);
    std::uint64_t random = 12345;
    for (int round = 0; round < 150; ++round) {
      random = random * 6364136223846793005u + 1442695040888963407u;
      const std::size_t at = (random >> 33) % bytes.size();
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << ((random >> 20) % 8)));
      SCOPED_TRACE(at);
      read_damaged(write_bytes("b.h5", damaged));
    }
  }
}

TEST_F(Hdf5Safety, PipesAreRefused) {
  ASSERT_EQ(::mkfifo(path("pipe.h5").c_str(), 0600), 0);
  expect_error(path("pipe.h5"), {"regular file", "pipe"});
}

TEST_F(Hdf5Safety, ReadersLeaveNoDescriptorsBehind) {
  const auto count = [] {
    std::size_t open = 0;
    DIR* folder = ::opendir("/proc/self/fd");
    while (::readdir(folder) != nullptr) ++open;
    ::closedir(folder);
    return open;
  };
  const std::string name = source_file("x.h5");
  open_volume(name);
  const std::size_t before = count();
  for (int i = 0; i < 8; ++i) {
    const auto first = open_volume(name), second = open_volume(name);
    EXPECT_EQ(read_all(*first).voxels<std::uint8_t>()[23], 23);
    EXPECT_EQ(read_all(*second).voxels<std::uint8_t>()[22], 22);
  }
  EXPECT_EQ(count(), before);
}

}  // namespace
}  // namespace cvr::volumes
