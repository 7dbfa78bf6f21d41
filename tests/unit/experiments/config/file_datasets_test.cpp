// Files without a description as data sets of a configuration: they say themselves what they hold.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "experiments/run/load_config.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "volumes/error.hpp"
#include "volumes/io/io.hpp"

namespace cvr::experiments {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using volumes::VolumeKind;
using volumes::VoxelType;

class FileDatasets : public testing::Test {
 protected:
  FileDatasets() {
    folder_.write("datasets/none.yaml", "");
    write("tissue.seg.nrrd", VoxelType::kU32, VolumeKind::kLabels, {5, 6, 7});
    write("below/tissue.nrrd", VoxelType::kU16, VolumeKind::kLabels, {3, 4, 5});
  }
  void write(const std::string& name, VoxelType type, VolumeKind kind,
             const volumes::Extent& extent) {
    std::filesystem::create_directories(std::filesystem::path(folder_ / name).parent_path());
    const volumes::Volume volume({.extent = extent, .type = type, .kind = kind});
    volumes::write_volume(folder_ / name, volumes::MemorySource(volume));
  }
  Config load(const std::string& datasets) {
    const std::string path =
        folder_.write("c.yaml", "matrix:\n  - datasets: [" + datasets +
                                    "]\n    codecs: [raw]\n    stages: [decode]\n");
    return load_config(path, Catalogue(), {});
  }
  std::string error(const std::string& datasets) {
    try {
      load(datasets);
    } catch (const volumes::InputError& e) {
      return e.what();
    }
    return "no error";
  }
  ScratchFolder folder_;
};

TEST_F(FileDatasets, SayThemselvesWhatTheyHold) {
  const Config config = load("{file: tissue.seg.nrrd, kind: labels}");
  const Dataset& dataset = *config.cells.back().dataset;
  EXPECT_EQ(dataset.name, "tissue");
  EXPECT_EQ(dataset.title, "tissue");
  EXPECT_EQ(dataset.full_extent, (volumes::Extent{5, 6, 7}));
  EXPECT_EQ(dataset.type, VoxelType::kU32);
  EXPECT_EQ(dataset.kind, VolumeKind::kLabels);
  const Location location = locate(dataset, {});
  ASSERT_TRUE(location.present) << location.missing;
  EXPECT_EQ(location.path, folder_ / "tissue.seg.nrrd");
  EXPECT_EQ(location.label, "");
}

TEST_F(FileDatasets, VoxelSizeOfTheConfigurationCountsWhereTheFileSaysNone) {
  const Config config =
      load("{file: tissue.seg.nrrd, name: t, voxel_size: [4, 4, 40], voxel_unit: nm}");
  const Location location = locate(*config.cells.back().dataset, {});
  EXPECT_EQ(location.info.voxel_size, (std::array{4.0, 4.0, 40.0}));
  EXPECT_THAT(error("{file: tissue.seg.nrrd, voxel_unit: nm}"),
              HasSubstr("voxel_unit only beside a voxel_size"));
}

TEST_F(FileDatasets, TwoOfOneNameNeedNames) {
  EXPECT_THAT(error("{file: tissue.seg.nrrd}, {file: below/tissue.nrrd}"),
              AllOf(HasSubstr("c.yaml: expected different names"), HasSubstr("'tissue'")));
  EXPECT_THAT(error("{generator: cells, extent: [4, 4, 4], name: c}, "
                    "{generator: cells, extent: [4, 4, 4], name: c, seed: 2}"),
              HasSubstr("two that are called 'c'"));
  EXPECT_THAT(
      error("{file: below/tissue.nrrd, kind: labels}, {file: below/tissue.nrrd, kind: scalars}"),
      HasSubstr("two that are called 'tissue'"));
  const Config config = load("{file: tissue.seg.nrrd}, {file: below/tissue.nrrd, name: other}");
  EXPECT_EQ(config.cells.size(), 4u);
}

TEST_F(FileDatasets, WhatCannotBeReadIsAnErrorAtItsPlace) {
  EXPECT_THAT(error("{file: absent.nrrd}"),
              AllOf(HasSubstr("c.yaml:2:"), HasSubstr("absent.nrrd")));
  folder_.write("broken.nrrd", "NRRD0004\ntype: uchar\n");
  EXPECT_THAT(error("{file: broken.nrrd}"),
              AllOf(HasSubstr("c.yaml:2:"), HasSubstr("broken.nrrd")));
  EXPECT_THAT(error("{file: '${CVRBENCH_DATA}/a.nrrd'}"), HasSubstr("configs/datasets"));
  EXPECT_THAT(error("{file: tissue.seg.nrrd, scale: 2}"),
              HasSubstr("expected one of the keys file"));
}

}  // namespace
}  // namespace cvr::experiments
