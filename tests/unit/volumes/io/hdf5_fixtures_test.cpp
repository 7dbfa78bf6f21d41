// HDF5 files of other writers, with the values that other programs read from them
// (CVRBENCH_FIXTURES).
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/unit/volumes/io/io_fixture.hpp"

namespace cvr::volumes {
namespace {

using Json = nlohmann::json;
using Index = std::vector<std::uint64_t>;

/// What the tables say of filters and types that are refused, by name.
std::string refusal_of(const Json& volume) {
  for (const Json& filter : volume["filters"]) {
    const auto text = filter.get<std::string>();
    for (const auto& [number, name] : {std::pair{"32000", "lzf (filter 32000)"},
                                       {"32001", "blosc (filter 32001)"},
                                       {"32004", "lz4 (filter 32004)"},
                                       {"32008", "bitshuffle (filter 32008)"}}) {
      if (text.starts_with(number)) return name;
    }
  }
  if (volume["dtype"] == "float64") return "f64 (float64)";
  return volume["shape"].size() == 1 ? "rank 1" : "";
}

/// The place of x, y, z and t in the shape.
std::string axes_of(const Json& volume) {
  const auto stated = volume["axes"].get<std::string>();
  if (stated.starts_with("xyz")) return "xyz";
  if (stated == "zyxc") return "zyxc";
  return std::string("tzyx").substr(4 - volume["shape"].size());
}

class Hdf5Fixtures : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("CVRBENCH_FIXTURES");
    if (folder == nullptr) GTEST_SKIP() << "CVRBENCH_FIXTURES names no folder of files: absent";
    folder_ = std::filesystem::path(folder) / "hdf5";
    std::ifstream stream(folder_ / "expected.json");
    cases_ = Json::parse(stream);
    ASSERT_GT(cases_.size(), 10u);
  }

  void check(const std::string& name, const Json& expected) const {
    const std::string axes = axes_of(expected);
    const auto shape = expected["shape"].get<Index>();
    const auto source = open_volume(name);
    const Volume volume = read_all(*source);
    std::map<char, std::uint64_t> size{{'x', 1}, {'y', 1}, {'z', 1}, {'t', 1}};
    for (std::size_t i = 0; i < axes.size(); ++i) size[axes[i]] = shape[i];
    ASSERT_EQ(volume.extent(), (Extent{size['x'], size['y'], size['z'] * size['t']}));
    for (const Json& voxel : expected["voxels"]) {
      std::map<char, std::uint64_t> at;
      for (std::size_t i = 0; i < axes.size(); ++i) at[axes[i]] = voxel[0][i].get<std::uint64_t>();
      const Coordinate place{at['x'], at['y'], at['z'] + at['t'] * size['z']};
      const std::uint64_t index = volume.extent().index(place);
      switch (volume.info().type) {
        case VoxelType::kF32:
          EXPECT_EQ(volume.voxels<float>()[index], voxel[1].get<float>());
          break;
        case VoxelType::kI16:
          EXPECT_EQ(volume.voxels<std::int16_t>()[index], voxel[1].get<int>());
          break;
        default:
          EXPECT_EQ(volume.label(place), voxel[1].get<std::uint64_t>());
      }
    }
    check_counts(volume, expected);
    expect_boxes(*source, volume);
  }

  /// The sum modulo 2^64 (tables give sums beyond as floating point, which says less), and voxels
  /// that are not 0.
  static void check_counts(const Volume& volume, const Json& expected) {
    std::uint64_t nonzero = 0, sum = 0;
    with_voxel_type(volume.info().type, [&]<class T>() {
      for (const T value : volume.voxels<T>()) {
        nonzero += value != 0 ? 1 : 0;
        sum += static_cast<std::uint64_t>(value);
      }
    });
    EXPECT_EQ(nonzero, expected["nonzero"].get<std::uint64_t>());
    if (expected["sum"].is_number_unsigned()) {
      EXPECT_EQ(sum, expected["sum"].get<std::uint64_t>());
    }
  }

  std::filesystem::path folder_;
  Json cases_;
};

TEST_F(Hdf5Fixtures, EveryDatasetIsReadRightOrRefusedByName) {
  std::size_t read = 0, refused = 0;
  for (const Json& file : cases_) {
    for (const Json& volume : file["volumes"]) {
      const std::string name = (folder_ / file["path"].get<std::string>()).string() + ":/" +
                               volume["open"].get<std::string>();
      SCOPED_TRACE(name);
      try {
        check(name, volume);
        ++read;
        EXPECT_NE(refusal_of(volume), "f64 (float64)");
      } catch (const InputError& error) {
        ++refused;
        const std::string reason = refusal_of(volume);
        ASSERT_FALSE(reason.empty()) << error.what();
        EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
      }
    }
  }
  EXPECT_GE(read, 20u);  // filters that are installed are read
  EXPECT_GE(refused, 4u);
}

TEST_F(Hdf5Fixtures, PlacesAndSizesAreRead) {
  const auto info = [&](const char* name) {
    return open_volume((folder_ / name).string())->info();
  };
  using Triple = std::array<double, 3>;
  const VolumeInfo cremi = info("cremi_style.h5:/volumes/labels/neuron_ids");
  EXPECT_EQ(cremi.voxel_size, (Triple{4, 4, 40}));
  EXPECT_EQ(cremi.offset, (Triple{3644, 3644, 1480}));
  EXPECT_EQ(cremi.voxel_unit, "nm");
  EXPECT_EQ(info("plantseg_sample_ovule.h5:/label").voxel_size, (Triple{0.15, 0.15, 0.235}));
  EXPECT_EQ(info("plantseg_sample_ovule.h5:/label").voxel_unit, "um");
  const VolumeInfo vigra = info("vigra_axistags_xyz_u8.h5");
  EXPECT_EQ(vigra.voxel_size, (Triple{0.3, 0.3, 1.1}));
  EXPECT_EQ(vigra.extent, (Extent{57, 61, 31}));
}

}  // namespace
}  // namespace cvr::volumes
