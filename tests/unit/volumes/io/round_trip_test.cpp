// Every voxel type through every format: voxels, extent, kind and voxel size come back, nothing
// else is left on disk.
#include <fmt/format.h>

#include "tests/unit/volumes/io/io_fixture.hpp"
#include "volumes/io/nrrd.hpp"

namespace cvr::volumes {
namespace {

struct Case {
  VoxelType type;
  VolumeKind kind;
};
constexpr std::array kCases{
    Case{VoxelType::kU8, VolumeKind::kLabels},   Case{VoxelType::kU16, VolumeKind::kLabels},
    Case{VoxelType::kU32, VolumeKind::kLabels},  Case{VoxelType::kU64, VolumeKind::kLabels},
    Case{VoxelType::kU8, VolumeKind::kScalars},  Case{VoxelType::kU16, VolumeKind::kScalars},
    Case{VoxelType::kI16, VolumeKind::kScalars}, Case{VoxelType::kF32, VolumeKind::kScalars},
};

class RoundTrip : public IoTest, public testing::WithParamInterface<const char*> {};

TEST_P(RoundTrip, KeepsVoxelsAndInfo) {
  const std::string ending = GetParam();
  for (const Extent& extent :
       {Extent{70, 13, 67}, Extent{1, 1, 1}, Extent{1, 9, 1}, Extent{5, 7, 3}}) {
    for (const Case& c : kCases) {
      SCOPED_TRACE(
          fmt::format("{} {} {} {}", ending, to_string(extent), name_of(c.type), name_of(c.kind)));
      const Volume volume = patterned(extent, c.type, c.kind);
      const std::string name = path("volume" + ending);
      write_volume(name, MemorySource(volume));
      const auto source = open_volume(name);
      EXPECT_EQ(source->info().extent, extent);
      EXPECT_EQ(source->info().kind, c.kind);
      ASSERT_EQ(source->info().type, c.type);
      const bool nifti = ending.starts_with(".nii");
      EXPECT_EQ(source->info().voxel_unit, nifti ? "um" : "nm");
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double expected = volume.info().voxel_size[axis] * (nifti ? 1e-3 : 1);
        EXPECT_NEAR(source->info().voxel_size[axis], expected, nifti ? expected * 1e-6 : 0);
      }
      expect_boxes(*source, volume);
    }
  }
}

TEST_P(RoundTrip, KeepsTheOffset) {
  const std::string ending = GetParam();
  for (const std::uint64_t steps : {1u, 2u}) {
    Volume volume = patterned({5, 7, 4}, VoxelType::kU16, VolumeKind::kLabels);
    volume.info().offset = {-1200, 0.25, 33000};
    volume.info().time_steps = steps;
    const std::string name = path("volume" + ending);
    write_volume(name, MemorySource(volume));
    const auto source = open_volume(name);
    const double factor = ending.starts_with(".nii") ? 1e-3 : 1;  // micrometres
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_DOUBLE_EQ(source->info().offset[axis], volume.info().offset[axis] * factor) << ending;
      EXPECT_DOUBLE_EQ(source->info().voxel_size[axis], volume.info().voxel_size[axis] * factor)
          << ending;
    }
    EXPECT_EQ(source->info().voxel_unit, factor == 1 ? "nm" : "um");
    EXPECT_EQ(source->info().time_steps, steps);
    expect_boxes(*source, volume);
    EXPECT_FALSE(source->files().empty());
    for (const std::string& file : source->files())
      EXPECT_TRUE(std::filesystem::exists(file)) << file;
  }
}

TEST_P(RoundTrip, KeepsSeries) {
  const std::string name = path(std::string("series") + GetParam());
  for (const auto& [extent, steps] :
       {std::pair{Extent{9, 13, 70 * 3}, 3u}, {Extent{5, 7, 4}, 4u}, {Extent{3, 2, 6}, 2u}}) {
    SCOPED_TRACE(fmt::format("{} {} in {} steps", GetParam(), to_string(extent), steps));
    Volume volume = patterned(extent, VoxelType::kI16, VolumeKind::kScalars);
    volume.info().time_steps = steps;
    write_volume(name, MemorySource(volume));
    const auto source = open_volume(name);
    EXPECT_EQ(source->info().extent, extent);
    EXPECT_EQ(source->info().time_steps, steps);
    expect_boxes(*source, volume);
    const Extent step = volume.info().step_extent();
    for (const auto& [suffix, first, count] :
         {std::tuple{"[1]", 1u, 1u}, {"[0:1]", 0u, 1u}, {"[1:2]", 1u, 1u}, {"[0:2]", 0u, 2u}}) {
      const auto part = open_volume(name + suffix);
      EXPECT_EQ(part->info().extent, (Extent{step.x, step.y, step.z * count})) << suffix;
      EXPECT_EQ(part->info().time_steps, count) << suffix;
      EXPECT_EQ(plain_bytes(read_all(*part)),
                plain_bytes(volume).substr(first * step.voxels() * 2, count * step.voxels() * 2))
          << suffix;
    }
    expect_error(name + fmt::format("[{}]", steps), {fmt::format("from 0 to {}", steps - 1)});
    expect_error(name + fmt::format("[0:{}]", steps + 1), {"0 <= A < B"});
  }
  const Volume single = patterned({3, 2, 6}, VoxelType::kI16, VolumeKind::kScalars);
  write_volume(name, MemorySource(single));
  EXPECT_EQ(open_volume(name)->info().time_steps, 1u);
  expect_error(name + "[0]", {"single volume", "[0]"});
}

INSTANTIATE_TEST_SUITE_P(Formats, RoundTrip,
                         testing::Values(".h5", ".nrrd", ".nhdr", ".nii", ".nii.gz", ".raw"),
                         [](const auto& info) {
                           std::string name(info.param + 1);
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

using Writers = IoTest;

TEST_F(Writers, PrecomputedFoldersHaveNoTime) {
  Volume volume = patterned({5, 7, 4}, VoxelType::kU8, VolumeKind::kScalars);
  volume.info().time_steps = 2;
  try {
    write_volume(path("a.precomputed"), MemorySource(volume));
    ADD_FAILURE() << "a series was written";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no time axis, found a series of 2 steps"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(Writers, LeaveOnlyTheirFiles) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU16, VolumeKind::kLabels);
  for (const char* name :
       {"a.h5", "b.nrrd", "c.nhdr", "d.nii", "e.nii.gz", "f.raw", "g.precomputed"}) {
    write_volume(path(name), MemorySource(volume));
    write_volume(path(name), MemorySource(volume));
  }
  expect_files({"a.h5", "b.nrrd", "c.nhdr", "c.nhdr.bin", "d.nii", "e.nii.gz", "f.raw",
                "f.raw.yaml", "g.precomputed"});
}

TEST_F(Writers, GiveEqualFilesForEqualVolumes) {
  const Volume volume = patterned({70, 13, 67}, VoxelType::kU32, VolumeKind::kLabels);
  for (const char* ending : {".h5", ".nrrd", ".nii.gz", ".raw"}) {
    write_volume(path(std::string("one") + ending), MemorySource(volume));
    write_volume(path(std::string("two") + ending), MemorySource(volume));
    EXPECT_EQ(read_bytes(path(std::string("one") + ending)),
              read_bytes(path(std::string("two") + ending)))
        << ending;
  }
}

/// A source that fails half way.
class FailingSource final : public VolumeSource {
 public:
  const VolumeInfo& info() const override { return info_; }
  void read(const Box& box, std::byte* out) const override {
    if (box.origin.z > 0) throw InputError("source: broken");
    std::memset(out, 1, box.size.voxels());
  }

 private:
  VolumeInfo info_{.extent = {64, 64, 200}, .type = VoxelType::kU8, .voxel_unit = {}};
};

TEST_F(Writers, KeepTheOldFileWhenTheSourceFails) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU8, VolumeKind::kLabels);
  for (const char* name : {"a.h5", "b.nrrd", "c.nhdr", "d.nii", "e.nii.gz", "f.raw"}) {
    write_volume(path(name), MemorySource(volume));
    EXPECT_THROW(write_volume(path(name), FailingSource()), InputError) << name;
    expect_boxes(*open_volume(path(name)), volume);
  }
  EXPECT_THROW(write_volume(path("g.precomputed"), FailingSource()), InputError);
  expect_files(
      {"a.h5", "b.nrrd", "c.nhdr", "c.nhdr.bin", "d.nii", "e.nii.gz", "f.raw", "f.raw.yaml"});
}

/// Gives its boxes to HDF5 while HDF5 is being written, and keeps what the file says of its origin.
TEST_F(Writers, ConvertFromFileToFile) {
  class Named final : public VolumeSource {
   public:
    explicit Named(const Volume& volume) : memory_(volume) {}
    const VolumeInfo& info() const override { return memory_.info(); }
    void read(const Box& box, std::byte* out) const override { memory_.read(box, out); }
    Provenance provenance() const override {
      return {"a: name # 1", "line one\nline \\two", "CC BY 4.0"};
    }

   private:
    MemorySource memory_;
  };
  const Volume volume = patterned({70, 13, 67}, VoxelType::kU64, VolumeKind::kLabels);
  write_volume(path("a.h5"), Named(volume));
  write_volume(path("b.h5"), *open_volume(path("a.h5")));
  write_volume(path("c.nrrd"), *open_volume(path("b.h5")));
  write_volume(path("d.raw"), *open_volume(path("c.nrrd")));
  const auto last = open_volume(path("d.raw"));
  EXPECT_EQ(last->provenance(), Named(volume).provenance());
  expect_boxes(*last, volume);
}

TEST_F(Writers, RefuseFoldersAndMissingFolders) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU8, VolumeKind::kLabels);
  std::filesystem::create_directory(path("folder.raw"));
  EXPECT_THROW(write_volume(path("folder.raw"), MemorySource(volume)), OutputError);
  for (const char* name :
       {"none/a.h5", "none/b.nrrd", "none/d.nii", "none/f.raw", "none/g.precomputed"}) {
    EXPECT_THROW(write_volume(path(name), MemorySource(volume)), OutputError) << name;
  }
  for (const char* name : {"a.tif", "a.h5[1]"}) {
    EXPECT_THROW(write_volume(path(name), MemorySource(volume)), InputError) << name;
  }
}

using Names = IoTest;

TEST_F(Names, TellVolumesFromOtherFiles) {
  for (const char* name :
       {"a.h5", "a.hdf5", "a.h5:/x", "a.h5:/x/y[3]", "a.h5[3]", "a.nrrd", "a.nhdr", "a.nii",
        "a.nii.gz", "a.nii.gz[2]", "a.nii[0:2]", "a.raw", "a.raw[1]", "a.precomputed",
        "a.precomputed/8_8_40", "a.precomputed/b.h5", "new/"}) {
    EXPECT_TRUE(is_volume_path(name)) << name;
  }
  for (const char* name : {"a.cvr", "a.gz", "h5", ".h5", "a.raw.yaml", "a.nii[1:]", "a.nii[x]", "a",
                           "", "a.nii.bz2"}) {
    EXPECT_FALSE(is_volume_path(name)) << name;
  }
}

TEST_F(Names, CapitalEndingsAreEndings) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU16, VolumeKind::kLabels);
  for (const char* name : {"A.NRRD", "B.NHDR", "C.NII", "D.NII.GZ", "E.Raw"}) {
    write_volume(path(name), MemorySource(volume));
    expect_boxes(*open_volume(path(name)), volume);
    EXPECT_TRUE(is_volume_path(std::string(name) + "[1]")) << name;
  }
  EXPECT_EQ(read_bytes(path("D.NII.GZ")).substr(0, 2), "\x1f\x8b");
  EXPECT_TRUE(std::filesystem::exists(path("B.NHDR.bin")));
}

TEST_F(Names, ErrorsSayWhatToType) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU16, VolumeKind::kLabels);
  std::filesystem::create_directory(path("emptydir"));
  try {
    write_volume(path("emptydir"), MemorySource(volume));
    ADD_FAILURE() << "a folder was written";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("type " + path("emptydir") + "/ for"), std::string::npos) << text;
  }
  expect_error(path("emptydir"), {"a folder without a file info"});
  expect_error(path("a.tif"), {"the ending '.tif'", ".nii.gz"});
  expect_error(path("a"), {"a name without an ending"});
  expect_error(path("a.hdr"), {"'.hdr'", "pair", ".nii"});
  expect_error(path("a.nii[-1]"), {"'[-1]'", "from 0"});
  EXPECT_THROW(open_volume(std::string()), InputError);
}

TEST_F(Names, LyingEndingsAreNamed) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU16, VolumeKind::kLabels);
  write_volume(path("a.h5"), MemorySource(volume));
  write_volume(path("b.nrrd"), MemorySource(volume));
  write_volume(path("c.nii"), MemorySource(volume));
  const auto renamed = [&](const char* from, const char* to) {
    return write_bytes(to, read_bytes(path(from)));
  };
  expect_error(renamed("a.h5", "x.nrrd"), {"an HDF5 file"});
  expect_error(renamed("c.nii", "x.nrrd"), {"a NIfTI-1"});
  expect_error(renamed("b.nrrd", "x.nii"), {"an NRRD file"});
  expect_error(renamed("a.h5", "x.nii"), {"an HDF5 file"});
  expect_error(write_bytes("x.nrrd", gzipped(read_bytes(path("b.nrrd")))), {"gzip data"});
  expect_error(write_bytes("x.nii.gz", gzipped(std::string("\x89PNG") + std::string(400, 'x'))),
               {"a PNG image"});
  expect_error(write_bytes("x.nrrd", "PK\3\4"), {"a zip archive"});
}

TEST_F(Names, MissingFilesAndFoldersAreErrors) {
  for (const char* ending :
       {".h5", ".nrrd", ".nhdr", ".nii", ".nii.gz", ".raw", ".precomputed", ".tif"}) {
    expect_error(path(std::string("none") + ending), {std::string("none") + ending});
    std::filesystem::create_directory(path(std::string("folder") + ending));
    expect_error(path(std::string("folder") + ending), {std::string("folder") + ending});
  }
}

TEST_F(Names, EmptyAndForeignFilesAreErrors) {
  for (const char* ending : {".h5", ".nrrd", ".nhdr", ".nii", ".nii.gz", ".raw"}) {
    expect_error(write_bytes(std::string("empty") + ending, ""), {std::string("empty") + ending});
    std::string noise;
    for (unsigned i = 0; i < 5000; ++i) noise += static_cast<char>(i * 2654435761u >> 11);
    expect_error(write_bytes(std::string("noise") + ending, noise),
                 {std::string("noise") + ending});
  }
}

/// Every prefix of a small file is refused: at opening, or when the missing voxels are read.
TEST_F(Names, TruncatedFilesAreErrors) {
  const Volume volume = patterned({5, 7, 3}, VoxelType::kU16, VolumeKind::kLabels);
  for (const char* ending : {".nrrd", ".nii", ".nii.gz", ".raw"}) {
    const std::string whole = path(std::string("whole") + ending);
    write_volume(whole, MemorySource(volume));
    const std::string bytes = read_bytes(whole);
    if (std::string(ending) == ".raw") std::filesystem::copy(whole + ".yaml", path("cut.raw.yaml"));
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      const std::string cut =
          write_bytes(std::string("cut") + ending, std::string_view(bytes).substr(0, length));
      EXPECT_THROW(read_all(*open_volume(cut)), InputError)
          << ending << " of " << length << " bytes";
    }
  }
}

/// Any single changed byte of a small file gives a volume or an InputError, and never anything
/// else.
TEST_F(Names, ChangedBytesGiveVolumesOrErrors) {
  const Volume volume = patterned({5, 4, 3}, VoxelType::kU32, VolumeKind::kLabels);
  for (const char* name : {"a.nrrd", "b.nhdr", "d.nii", "e.nii.gz", "f.raw", "g.precomputed"}) {
    write_volume(path(name), MemorySource(volume));
  }
  const std::array<std::array<std::string, 2>, 8> cases{
      {{"a.nrrd", "a.nrrd"},
       {"b.nhdr", "b.nhdr"},
       {"d.nii", "d.nii"},
       {"e.nii.gz", "e.nii.gz"},
       {"f.raw", "f.raw"},
       {"f.raw", "f.raw.yaml"},
       {"g.precomputed", "g.precomputed/info"},
       {"g.precomputed", "g.precomputed/8_4.5_40/0-5_0-4_0-3"}}};
  unsigned refused = 0;
  for (const auto& [opened, changed] : cases) {
    const std::string good = read_bytes(path(changed));
    for (std::size_t at = 0; at < std::min<std::size_t>(good.size(), 700); ++at) {
      for (const char flip : {'\x01', '\x10', '\x80', '\xff'}) {
        std::string bytes = good;
        bytes[at] = static_cast<char>(bytes[at] ^ flip);
        write_bytes(changed, bytes);
        try {
          const auto source = open_volume(path(opened));
          if (source->info().bytes() < (1u << 24)) read_all(*source);
        } catch (const InputError&) {
          ++refused;
        }
      }
    }
    write_bytes(changed, good);
  }
  EXPECT_GT(refused, 1000u);
}

}  // namespace
}  // namespace cvr::volumes
