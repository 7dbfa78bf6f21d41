// Precomputed folders that other programs wrote, where CVRBENCH_FIXTURES names some.
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/unit/volumes/io/precomputed_fixture.hpp"

namespace cvr::volumes {
namespace {

/// Shape, type, voxels and sum as the description of a volume says; its lists are slowest axis
/// first.
void expect_volume(const std::string& name, const nlohmann::json& expected) {
  const auto source = open_volume(name);
  const VolumeInfo& info = source->info();
  EXPECT_EQ(expected["shape"], nlohmann::json({info.extent.z, info.extent.y, info.extent.x}));
  EXPECT_EQ(expected["voxel_size"],
            nlohmann::json({info.voxel_size[2], info.voxel_size[1], info.voxel_size[0]}));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(info.offset[axis],
              expected["voxel_offset"][2 - axis].get<double>() * info.voxel_size[axis]);
  }
  const Volume volume = read_all(*source);
  const auto value = [&](const Coordinate& at) {
    return info.type == VoxelType::kF32 ? volume.voxels<const float>()[info.extent.index(at)]
                                        : double(volume.label(at));
  };
  for (const auto& [index, found] :
       expected["voxels"].get<std::vector<std::pair<std::array<std::uint64_t, 3>, double>>>()) {
    EXPECT_EQ(value({index[2], index[1], index[0]}), found);
  }
  long double sum = 0;
  std::uint64_t nonzero = 0;
  for (std::uint64_t i = 0; i < info.extent.voxels(); ++i) {
    const Coordinate at = info.extent.coordinate(i);
    sum += info.type == VoxelType::kF32 ? value(at) : static_cast<long double>(volume.label(at));
    nonzero += value(at) != 0;
  }
  EXPECT_EQ(nonzero, expected["nonzero"].get<std::uint64_t>());
  const double total = expected["sum"].get<double>();
  EXPECT_NEAR(static_cast<double>(sum), total, std::fabs(total) * 1e-12);
}

/// What other programs wrote, with what the voxels must be. A case that is not read is refused, and
/// says why: support cannot shrink unnoticed.
TEST_F(Precomputed, FoldersOfOtherPrograms) {
  const char* fixtures = std::getenv("CVRBENCH_FIXTURES");
  const std::filesystem::path folder =
      std::filesystem::path(fixtures == nullptr ? "" : fixtures) / "precomputed";
  if (!std::filesystem::is_regular_file(folder / "expected.json"))
    GTEST_SKIP() << "CVRBENCH_FIXTURES names no folder with precomputed/";
  const std::map<std::string, std::string> refusals{
      {"cloudvolume_compresso_u32/32_32_40",
       "encoding: expected raw or compressed_segmentation, which are read, found \"compresso\""},
      {"neuroglancer_one_channel/3_4_5", "expected the folder of a scale, found none"},
      {"neuroglancer_one_channel/6_8_10", "expected the folder of a scale, found none"},
      {"neuroglancer_one_channel/12_16_20", "expected the folder of a scale, found none"},
      {"neuroglancer_two_channels/3_4_5", "num_channels: expected 1"},
      {"neuroglancer_two_channels/6_8_10", "num_channels: expected 1"},
      {"neuroglancer_two_channels/12_16_20", "num_channels: expected 1"},
      {"raw_u8_two_channels/2_2_5", "num_channels: expected 1"},
      {"ngs_jpeg_u8/4mm", "found \"jpeg\""},
      {"png_u8/2_2_5", "found \"png\""},
      {"ngs_sharded_identity_u32/32mm", "sharding: expected an unsharded scale"},
      {"cv_sharded_murmur_gz_gz_u64/32_32_40", "sharding: expected an unsharded scale"},
      {"cv_sharded_murmur_gz_gz_u64/64_64_80", "sharding: expected an unsharded scale"},
      {"cv_sharded_identity_single_u8/4.5_4.5_12.25", "sharding: expected an unsharded scale"},
      {"cv_sharded_murmur_raw_raw_u16_missing/16_16_40", "sharding: expected an unsharded scale"},
  };
  std::size_t read = 0, refused = 0;
  for (const auto& one : nlohmann::json::parse(read_bytes((folder / "expected.json").string()))) {
    for (const auto& expected : one.at("volumes")) {
      const std::string open = expected.at("open");  // "scale N (key KEY)"
      const std::size_t start = open.find("(key ") + 5;
      const std::string name =
          one.at("path").get<std::string>() + "/" + open.substr(start, open.size() - 1 - start);
      SCOPED_TRACE(name);
      const std::string whole = (folder / name).string();
      if (const auto refusal = refusals.find(name); refusal != refusals.end()) {
        ++refused;
        try {
          open_volume(whole);
          ADD_FAILURE() << "was read";
        } catch (const InputError& error) {
          EXPECT_NE(std::string(error.what()).find(refusal->second), std::string::npos)
              << error.what();
        }
        continue;
      }
      ++read;
      expect_volume(whole, expected);
    }
  }
  EXPECT_EQ(read, 5u);
  EXPECT_EQ(refused, refusals.size());
}

}  // namespace
}  // namespace cvr::volumes
