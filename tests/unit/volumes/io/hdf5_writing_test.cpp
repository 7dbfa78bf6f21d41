// HDF5 outputs: what an existing file keeps, and what happens when there is no room.
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "tests/unit/volumes/io/hdf5_file.hpp"

namespace cvr::volumes {
namespace {

class Hdf5Writing : public IoTest {
 protected:
  /// A file with more than one volume: a group with an attribute, a table, links, another volume.
  std::string crowded() const {
    Hdf5File file(path("two.h5"));
    file.dataset("a", H5T_STD_U16BE, {2, 3, 4}, counting<std::uint16_t>(24))
        .text("a", "history", "made by hand");
    file.dataset("table", H5T_IEEE_F64LE, {7}, counting<double>(7));
    H5Gclose(H5Gcreate2(file.id(), "g", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    file.dataset("g/b", H5T_STD_U8LE, {2, 2, 2}, counting<std::uint8_t>(8))
        .numbers("g", "resolution", {4, 4, 40});
    H5Lcreate_soft("/a", file.id(), "soft", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_external("gone.h5", "/x", file.id(), "outside", H5P_DEFAULT, H5P_DEFAULT);
    file.text("/", "title", "two volumes");
    return file.close();
  }

  void expect_rest(const std::string& name) const {
    const hid_t file = H5Fopen(name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    std::vector<std::uint16_t> a(24);
    std::vector<double> table(7);
    const hid_t a_id = H5Dopen2(file, "a", H5P_DEFAULT),
                table_id = H5Dopen2(file, "table", H5P_DEFAULT);
    EXPECT_GE(H5Dread(a_id, H5T_NATIVE_UINT16, H5S_ALL, H5S_ALL, H5P_DEFAULT, a.data()), 0);
    EXPECT_GE(H5Dread(table_id, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, table.data()), 0);
    EXPECT_EQ(a, counting<std::uint16_t>(24));
    EXPECT_EQ(table, counting<double>(7));
    const hid_t type = H5Dget_type(a_id);
    EXPECT_GT(H5Tequal(type, H5T_STD_U16BE), 0);
    EXPECT_GT(H5Aexists(a_id, "history"), 0);
    EXPECT_GT(H5Aexists(file, "title"), 0);
    EXPECT_GT(H5Aexists_by_name(file, "g", "resolution", H5P_DEFAULT), 0);
    EXPECT_GT(H5Lexists(file, "soft", H5P_DEFAULT), 0);
    EXPECT_GT(H5Lexists(file, "outside", H5P_DEFAULT), 0);
    H5Tclose(type);
    H5Dclose(a_id);
    H5Dclose(table_id);
    H5Fclose(file);
  }

  /// Writing must throw Error with all of `parts`, leave the bytes of `file` as they are and
  /// nothing beside it.
  template <class Error>
  void expect_refused(const std::string& name, const VolumeSource& source, const std::string& file,
                      const std::vector<std::string>& parts) const {
    const std::string before = read_bytes(file);
    try {
      write_volume(name, source);
      ADD_FAILURE() << name << " was written";
    } catch (const Error& error) {
      for (const std::string& part : parts)
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
            << error.what() << " lacks " << part;
    }
    EXPECT_EQ(read_bytes(file), before);
    expect_files({std::filesystem::path(file).filename().string()});
  }
};

TEST_F(Hdf5Writing, ANamedDatasetIsAddedOrReplacedAlone) {
  const std::string name = crowded();
  const Volume volume = patterned({70, 9, 5}, VoxelType::kU32, VolumeKind::kLabels);
  const Volume scalars = patterned({3, 9, 5}, VoxelType::kI16, VolumeKind::kScalars);
  write_volume(name + ":/g/new/labels", MemorySource(volume));  // added
  write_volume(name + ":/g/b", MemorySource(scalars));          // replaced
  expect_rest(name);
  expect_boxes(*open_volume(name + ":/g/new/labels"), volume);
  const auto replaced = open_volume(name + ":/g/b");
  EXPECT_EQ(replaced->info().kind, VolumeKind::kScalars);
  expect_boxes(*replaced, scalars);
  // From the file into itself: the source is another dataset of it.
  write_volume(name + ":/g/b", *open_volume(name + ":/g/new/labels"));
  expect_rest(name);
  expect_boxes(*open_volume(name + ":/g/b"), volume);
  expect_files({"two.h5"});
}

TEST_F(Hdf5Writing, WhatWouldBeLostIsRefused) {
  const std::string name = crowded();
  const Volume volume = patterned({4, 4, 4}, VoxelType::kU8, VolumeKind::kLabels);
  const MemorySource source(volume);
  expect_refused<InputError>(name, source, name,
                             {"two.h5:/labels", "/a (rank 3, 2x3x4, u16)", "/g/b"});
  expect_refused<InputError>(name + ":/g", source, name, {"'/g'", "a group"});
  expect_refused<InputError>(name + ":/a/x", source, name, {"'/a'", "a dataset"});
  expect_refused<InputError>(name + ":/outside/x", source, name, {"'/outside'", "a link"});
  const std::string text = write_bytes("two.h5", "no HDF5 at all");
  expect_refused<InputError>(text, source, text, {"there already", "an HDF5 file"});
  expect_refused<InputError>(text + ":/x", source, text, {"there already"});
}

TEST_F(Hdf5Writing, ASingleVolumeOfOursIsReplaced) {
  write_volume(path("a.h5"),
               MemorySource(patterned({9, 4, 4}, VoxelType::kU8, VolumeKind::kLabels)));
  const Volume volume = patterned({4, 4, 4}, VoxelType::kU16, VolumeKind::kLabels);
  write_volume(path("a.h5"), MemorySource(volume));
  expect_boxes(*open_volume(path("a.h5")), volume);
  write_volume(path("b.h5"), MemorySource(volume));
  EXPECT_EQ(read_bytes(path("a.h5")), read_bytes(path("b.h5")));
  const Volume scalars = patterned({4, 4, 4}, VoxelType::kF32, VolumeKind::kScalars);
  write_volume(path("a.h5"), MemorySource(scalars));
  expect_boxes(*open_volume(path("a.h5")), scalars);
  std::filesystem::remove(path("a.h5"));
  std::filesystem::remove(path("b.h5"));
  const std::string other =
      Hdf5File(path("a.h5"))
          .dataset("other", H5T_STD_U8LE, {1, 1, 1}, counting<std::uint8_t>(1))
          .close();
  expect_refused<InputError>(other, MemorySource(scalars), other,
                             {"a.h5:/scalars", "/other (rank 3, 1x1x1, u8)"});
}

TEST_F(Hdf5Writing, TextsHaveFixedLength) {
  write_volume(path("a.h5"),
               MemorySource(patterned({9, 4, 4}, VoxelType::kU8, VolumeKind::kLabels)));
  EXPECT_EQ(read_bytes(path("a.h5")).find("GCOL"),
            std::string::npos);  // no heap of variable length
}

/// Volumes that gzip cannot make smaller.
Volume noise(std::uint64_t side) {
  Volume volume({.extent = {side, side, side}, .type = VoxelType::kU32});
  std::uint64_t random = 1;
  for (std::uint32_t& voxel : volume.voxels<std::uint32_t>()) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    voxel = static_cast<std::uint32_t>(random >> 32);
  }
  return volume;
}

TEST_F(Hdf5Writing, AFileSizeLimitIsAnOutputError) {
  const Volume volume = noise(100);
  const pid_t child = ::fork();  // the limit is for the rest of a process
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    int result = 1;
    for (const rlim_t limit : {4096, 1 << 20, 3 << 20}) {
      const rlimit bytes{limit, RLIM_INFINITY};
      ::setrlimit(RLIMIT_FSIZE, &bytes);
      try {
        write_volume(path("a.h5"), MemorySource(volume));
        ::_exit(2);
      } catch (const OutputError& error) {
        result = std::string(error.what()).find("File too large") == std::string::npos ? 3 : 0;
      } catch (...) {
        ::_exit(4);
      }
      if (result != 0) ::_exit(result);
    }
    ::_exit(result);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  expect_files({});
}

struct Unmount {
  std::string folder;
  ~Unmount() { ::umount2(folder.c_str(), MNT_DETACH); }
};

TEST_F(Hdf5Writing, AFullDiskIsAnOutputError) {
  std::filesystem::create_directory(path("disk"));
  if (::mount("none", path("disk").c_str(), "tmpfs", 0, "size=300k") != 0)
    GTEST_SKIP() << "no file system can be mounted";
  const Unmount unmount{path("disk")};
  const Volume small = patterned({4, 4, 4}, VoxelType::kU8, VolumeKind::kLabels);
  try {
    write_volume(path("disk/a.h5"), MemorySource(noise(64)));
    ADD_FAILURE();
  } catch (const OutputError& error) {
    EXPECT_NE(std::string(error.what()).find("No space left on device"), std::string::npos)
        << error.what();
  }
  EXPECT_TRUE(std::filesystem::is_empty(path("disk")));
  // An existing file keeps what it has.
  write_volume(path("disk/b.h5"), MemorySource(small));
  const std::string before = read_bytes(path("disk/b.h5"));
  EXPECT_THROW(write_volume(path("disk/b.h5:/more"), MemorySource(noise(64))), OutputError);
  EXPECT_EQ(read_bytes(path("disk/b.h5")), before);
}

}  // namespace
}  // namespace cvr::volumes
