// Where the voxels of a data set are, and what of it a worker is told.
#include <gtest/gtest.h>

#include "experiments/config/datasets.hpp"
#include "experiments/stages/stage.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "volumes/io/io.hpp"

namespace cvr::experiments {
namespace {

class Locations : public testing::Test {
 protected:
  void SetUp() override {
    volumes::VolumeInfo info;
    info.extent = {4, 5, 6};
    info.voxel_size = {1, 2, 3};
    info.voxel_unit = "nm";
    info.offset = {10, 20, 30};
    volumes::Volume volume(info);
    for (std::size_t i = 0; i < volume.extent().voxels(); ++i)
      volume.voxels<std::uint8_t>()[i] = static_cast<std::uint8_t>(i);
    volumes::write_volume(folder_ / "v.nrrd", volumes::MemorySource(volume));
    dataset_.name = std::string("volume");
    dataset_.extent = dataset_.full_extent = info.extent;
    dataset_.file = folder_ / "v.nrrd";
  }
  ScratchFolder folder_;
  Dataset dataset_;
};

TEST_F(Locations, ExchangedAxesExchangeSizeAndOffsetAndKeepTheFiles) {
  dataset_.exchange_axes = true;
  const Location location = locate(dataset_, {});
  ASSERT_TRUE(location.present) << location.missing;
  const auto source = open_location(location, 1);
  EXPECT_EQ(source->info().extent, (volumes::Extent{6, 5, 4}));
  EXPECT_EQ(source->info().voxel_size, (std::array<double, 3>{3, 2, 1}));
  EXPECT_EQ(location.info.offset, source->info().offset);
  dataset_.exchange_axes = false;
  const auto in_order = open_location(locate(dataset_, {}), 1);
  const std::array<double, 3> placed = in_order->info().offset;
  EXPECT_EQ(source->info().offset, (std::array<double, 3>{placed[2], placed[1], placed[0]}));
  EXPECT_EQ(source->files(), in_order->files());
  EXPECT_EQ(source->provenance(), in_order->provenance());
}

TEST_F(Locations, AxesAndExternalFilesAreToldToWorkersAndNameAnotherIdentity) {
  const Location plain = locate(dataset_, {});
  Dataset named = dataset_;
  named.allow_external = true;
  const Location external = locate(named, {});
  ASSERT_TRUE(plain.present && external.present);
  EXPECT_NE(plain.identity, external.identity);
  WorkerSpec spec;
  spec.location = external;
  spec.location.axes = "zyx";
  spec.codec = "raw";
  const Location told = worker_spec_from_json(to_json_line(spec)).location;
  EXPECT_EQ(told.axes, "zyx");
  EXPECT_TRUE(told.allow_external);
}

TEST_F(Locations, ADescriptionGivesItsVoxelSizeToVolumesThatSayNone) {
  dataset_.voxel_size = {7, 7, 7};
  EXPECT_EQ(locate(dataset_, {}).info.voxel_size, (std::array<double, 3>{1, 2, 3}))
      << "the file's own counts";
  Dataset made;
  made.name = "made";
  made.type = volumes::VoxelType::kU32;
  made.extent = made.full_extent = {8, 9, 10};
  made.generator = GeneratorChoice{"cells", 1, {}};
  const Location plain = locate(made, {});
  made.voxel_size = {2, 2, 2};
  EXPECT_EQ(locate(made, {}).identity, plain.identity) << "pictures are the same";
  made.voxel_size = {1, 1, 1};
  made.voxel_unit = "mm";
  EXPECT_EQ(open_location(locate(made, {}), 1)->info().voxel_unit, "mm");
  made.voxel_size = {3, 1, 1};
  for (const bool exchanged : {false, true}) {
    made.exchange_axes = exchanged;
    const Location sized = locate(made, {});
    EXPECT_NE(sized.identity, plain.identity);
    WorkerSpec spec;
    spec.location = sized;
    spec.codec = "raw";
    const Location told = worker_spec_from_json(to_json_line(spec)).location;
    const std::array<double, 3> expected =
        exchanged ? std::array<double, 3>{1, 1, 3} : std::array<double, 3>{3, 1, 1};
    EXPECT_EQ(told.info.voxel_size, expected);
    const auto source = open_location(told, 1);
    EXPECT_EQ(source->info().voxel_size, expected);
    EXPECT_EQ(source->info().extent, sized.info.extent);
    EXPECT_EQ(volumes::read_all(*source).info().voxel_size, expected);
  }
}

TEST(Sizes, ProductsDoNotOverflow) {
  EXPECT_FALSE(is_too_large({1 << 16, 1 << 16, 1 << 16}));
  EXPECT_TRUE(is_too_large({1 << 16, 1 << 16, (1 << 16) + 1}));
  EXPECT_TRUE(
      is_too_large({std::uint64_t{1} << 40, std::uint64_t{1} << 40, std::uint64_t{1} << 40}));
  EXPECT_TRUE(is_too_large({1, 1, 1}, UINT64_MAX));
}

TEST(Sizes, AxesAreLettersEachOnce) {
  for (const char* good : {"xyz", "zyx", "tzyxc", "xyzt"}) EXPECT_TRUE(are_axes(good)) << good;
  for (const char* bad : {"", "xy", "xyzz", "xyzq", "XYZ", "xyz "})
    EXPECT_FALSE(are_axes(bad)) << bad;
}

TEST(WorkerSpecification, OfAnotherRevisionIsUnderstood) {
  WorkerSpec spec;
  spec.codec = "csgvr-sb";
  spec.stage = "decode";
  spec.threads = 3;
  spec.location.info.extent = {4, 5, 6};
  const Row told = Row::parse(to_json_line(spec));
  EXPECT_TRUE(told.contains("fault")) << "workers of before the first release ask for it";
  EXPECT_FALSE(told.contains("generator") || told.contains("render"));
  Row other = told;
  other.erase("voxel_unit");
  other["of_tomorrow"] = 1;
  const WorkerSpec read = worker_spec_from_json(other.dump());
  EXPECT_EQ(read.codec, "csgvr-sb");
  EXPECT_EQ(read.stage, "decode");
  EXPECT_EQ(read.threads, 3u);
  EXPECT_EQ(read.location.info.extent, (volumes::Extent{4, 5, 6}));
  EXPECT_EQ(read.location.info.voxel_unit, "");
}

}  // namespace
}  // namespace cvr::experiments
