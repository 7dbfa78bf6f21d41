// Files of other implementations: each volume has the voxels that its writer meant, or is refused
// for a reason that the table names, so that support cannot shrink without a word.
// CVRBENCH_FIXTURES names the folder with one folder a format.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tests/unit/volumes/io/io_fixture.hpp"

namespace cvr::volumes {
namespace {

using Json = nlohmann::json;

struct Refusal {
  const char* reason;
  const char* axes = "";  ///< with these axes the volume is read after all
};

/// By the name under which a volume is opened. Everything else must be read.
const std::map<std::string, Refusal>& refusals() {
  static const std::map<std::string, Refusal> kRefusals{
      {"BallBinary30x30x30_bz2.nrrd", {"'bzip2'"}},
      {"teem_bzip2_u32_spacedirs.nrrd", {"'bzip2'"}},
      {"test_simple4d_raw.nrrd", {"float64 (NRRD type double)"}},
      {"SegmentationOverlapping.seg.nrrd", {"axis 1 of kind list", "txyz"}},
      {"teem_list_slices_u16/teem_list_slices_u16.nhdr", {"'LIST'"}},
      {"niftirs_27_rest/float64.nii", {"float64 (NIfTI code 64)"}},
      {"niftirs_minimal_pair/minimal.hdr", {"pair"}},
      {"niftirs_minimal_pair_gz/minimal.hdr.gz", {"pair"}},
      {"nibabel_functional_scl_4d.nii", {"slope 0.07540697, intercept 3100.7617"}},
      {"nibabel_example_nifti2.nii.gz", {"NIfTI-2"}},
      {"nrjs_5D_small_scl.nii", {"slope 0.002758141, intercept 0.07691902"}},
      {"nrjs_air_pair_gz/air.hdr.gz", {"pair"}},
      {"niivue_ras_pair/ras.hdr", {"pair"}},
      {"niivue_space_PSR.nii.gz", {"slope 0.3629564, intercept 0"}},
      {"niftirs_rgb.nii", {"RGB24 (NIfTI code 128)"}},
      {"nib_i16_scl_slope_qform_only.nii", {"slope 0.25, intercept -50"}},
      {"nib_u64_nifti2.nii.gz", {"NIfTI-2"}},
  };
  return kRefusals;
}

double voxel_value(const Volume& volume, std::uint64_t index) {
  return with_voxel_type(volume.info().type,
                         [&]<class T>() { return static_cast<double>(volume.voxels<T>()[index]); });
}

/// `shape` and indices are slowest axis first; leading axes of length 1 and missing ones are none
/// of the volume's.
void expect_volume(const VolumeSource& source, const Json& truth) {
  const Volume volume = read_all(source);
  const auto shape = truth.at("shape").get<std::vector<std::uint64_t>>();
  std::vector<std::uint64_t> found{source.info().time_steps, volume.info().step_extent().z,
                                   volume.extent().y, volume.extent().x};
  std::vector<std::uint64_t> expected = shape;
  while (expected.size() < found.size()) expected.insert(expected.begin(), 1);
  EXPECT_EQ(found, expected);
  double sum = 0;
  std::uint64_t exact = 0;
  for (std::uint64_t i = 0; i < volume.extent().voxels(); ++i) {
    sum += voxel_value(volume, i);
    if (is_label_type(volume.info().type))
      with_label_type(volume.info().type, [&]<class T>() { exact += volume.voxels<T>()[i]; });
  }
  if (is_label_type(volume.info().type)) {
    EXPECT_EQ(exact, truth.at("sum").get<std::uint64_t>());
  } else {
    EXPECT_NEAR(sum, truth.at("sum").get<double>(), 1e-9 * std::fabs(sum));
  }
  for (const Json& voxel : truth.at("voxels")) {
    std::uint64_t index = 0;
    for (std::size_t axis = 0; axis < shape.size(); ++axis)
      index = index * shape[axis] + voxel[0][axis].get<std::uint64_t>();
    EXPECT_EQ(voxel_value(volume, index), voxel[1].get<double>()) << voxel[0];
  }
}

/// The axes of a volume run along those of the space: then its offset is the translation of its
/// affine.
void expect_nifti_offset(const VolumeSource& source, const Json& truth) {
  if (truth.at("qform_code") == 0 && truth.at("sform_code") == 0) return;
  const auto affine = truth.at("affine").get<std::vector<std::vector<double>>>();
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::fabs(affine[axis][axis]) > 0.99 * source.info().voxel_size[axis]) {
      EXPECT_NEAR(source.info().offset[axis], affine[axis][3],
                  1e-5 * (1 + std::fabs(affine[axis][3])));
    }
}

class Fixtures : public testing::TestWithParam<const char*> {};

TEST_P(Fixtures, AreReadOrRefusedByName) {
  const char* folder = std::getenv("CVRBENCH_FIXTURES");
  if (folder == nullptr)
    GTEST_SKIP() << "CVRBENCH_FIXTURES names no folder of files of other implementations";
  const std::filesystem::path format = std::filesystem::path(folder) / GetParam();
  std::ifstream stream(format / "expected.json");
  ASSERT_TRUE(stream.is_open()) << format;
  std::size_t volumes = 0;
  for (const Json& entry : Json::parse(stream)) {
    for (const Json& truth : entry.at("volumes")) {
      const std::string name = truth.at("open");
      const std::string path = (format / name).string();
      SCOPED_TRACE(path);
      ++volumes;
      const auto refusal = refusals().find(name);
      if (refusal == refusals().end()) {
        try {
          const auto source = open_volume(path);
          expect_volume(*source, truth);
          if (truth.contains("affine")) expect_nifti_offset(*source, truth);
        } catch (const InputError& error) {
          ADD_FAILURE() << error.what();
        }
        continue;
      }
      try {
        read_all(*open_volume(path));
        ADD_FAILURE() << "was read; take it off the table of refusals";
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(refusal->second.reason));
      }
      if (const std::string axes = refusal->second.axes; !axes.empty()) {
        const auto source = open_volume(path, OpenOptions{.axes = axes});
        EXPECT_EQ(source->info().time_steps, truth.at("shape").back().get<std::uint64_t>());
        const Volume volume = read_all(*source);
        const auto voxels = volume.voxels<std::uint8_t>();
        EXPECT_EQ(std::accumulate(voxels.begin(), voxels.end(), std::uint64_t{0}),
                  truth.at("sum").get<std::uint64_t>());
      }
    }
  }
  EXPECT_GT(volumes, 15u);
}

INSTANTIATE_TEST_SUITE_P(Formats, Fixtures, testing::Values("nrrd", "nifti"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace cvr::volumes
