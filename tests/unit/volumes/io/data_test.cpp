// The real volumes of the folder CVRBENCH_DATA: every file opens and reads, and some have the
// shapes that are on record.
#include <cstdlib>
#include <map>

#include "tests/samples/real_data.hpp"
#include "tests/unit/volumes/io/io_fixture.hpp"

namespace cvr::volumes {
namespace {

struct Row {
  Extent extent;
  VoxelType type;
  VolumeKind kind;
  std::string unit;
};

const std::map<std::string, Row>& known_rows() {
  static const std::map<std::string, Row> kRows{
      {"battery_nmc.h5", {{301, 301, 251}, VoxelType::kU8, VolumeKind::kLabels, ""}},
      {"connectomics_pinky40_a.h5", {{1024, 512, 512}, VoxelType::kU32, VolumeKind::kLabels, "nm"}},
      {"em_fib19_64.h5", {{64, 64, 64}, VoxelType::kU64, VolumeKind::kLabels, "nm"}},
      {"frog_tissue.h5", {{500, 470, 136}, VoxelType::kU8, VolumeKind::kLabels, ""}},
      {"human_atlas_aal.h5", {{181, 217, 181}, VoxelType::kU8, VolumeKind::kLabels, "mm"}},
      {"snemi_mini_fragments.h5", {{160, 160, 32}, VoxelType::kU16, VolumeKind::kLabels, ""}},
      {"torso_organs.h5", {{122, 101, 112}, VoxelType::kU8, VolumeKind::kLabels, ""}},
      {"cranium_ct.h5", {{256, 256, 108}, VoxelType::kI16, VolumeKind::kScalars, ""}},
      {"engine.h5", {{256, 256, 128}, VoxelType::kU8, VolumeKind::kScalars, ""}},
      {"mouse_skull_ct_f32.h5", {{169, 268, 148}, VoxelType::kF32, VolumeKind::kScalars, ""}},
      {"weather_theta_series_f32.h5[5]", {{83, 83, 10}, VoxelType::kF32, VolumeKind::kScalars, ""}},
      {"asl_mr_series_f32.h5[24]", {{64, 64, 24}, VoxelType::kF32, VolumeKind::kScalars, ""}},
      {"asl_mr_series_f32.h5", {{64, 64, 24 * 25}, VoxelType::kF32, VolumeKind::kScalars, ""}},
  };
  return kRows;
}

class Data : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("CVRBENCH_DATA");
    CVR_SKIP_UNLESS(folder != nullptr, "CVRBENCH_DATA names no folder of volumes");
    folder_ = folder;
  }
  std::filesystem::path folder_;
};

TEST_F(Data, EveryFileOpensAndReads) {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    if (entry.path().extension() != ".h5") continue;
    SCOPED_TRACE(entry.path().string());
    const bool series = entry.path().stem().string().find("_series") != std::string::npos;
    const auto source = open_volume(entry.path().string());
    EXPECT_EQ(source->info().time_steps > 1, series);
    const VolumeInfo& info = source->info();
    std::vector<std::byte> plane(info.extent.x * info.extent.y * size_of(info.type));
    source->read({{0, 0, info.extent.z - 1}, {info.extent.x, info.extent.y, 1}}, plane.data());
    EXPECT_FALSE(source->provenance().source.empty());
    EXPECT_FALSE(source->provenance().licence.empty());
    ++files;
  }
  EXPECT_GT(files, 0u);
}

TEST_F(Data, KnownShapesAndTypes) {
  for (const auto& [name, row] : known_rows()) {
    SCOPED_TRACE(name);
    const std::string file = name.substr(0, name.find('['));
    if (!std::filesystem::exists(folder_ / file)) {
      EXPECT_EQ(std::getenv("CVRBENCH_REQUIRE_DATA"), nullptr) << file << " is absent";
      continue;
    }
    const auto source = open_volume((folder_ / name).string());
    EXPECT_EQ(source->info().extent, row.extent);
    EXPECT_EQ(source->info().type, row.type);
    EXPECT_EQ(source->info().kind, row.kind);
    if (!row.unit.empty()) {
      EXPECT_EQ(source->info().voxel_unit, row.unit);
    }
  }
}

TEST_F(Data, VoxelSizeOfTheAnisotropicVolume) {
  const std::filesystem::path file = folder_ / "connectomics_pinky40_a.h5";
  CVR_SKIP_UNLESS(std::filesystem::exists(file), file << " is absent");
  EXPECT_EQ(open_volume(file.string())->info().voxel_size, (std::array<double, 3>{8, 8, 40}));
}

TEST_F(Data, TheAtlasAgreesWithItsNiftiOriginal) {
  const std::string nifti = "/usr/share/mricron/templates/aal.nii.gz";
  const std::filesystem::path file = folder_ / "human_atlas_aal.h5";
  CVR_SKIP_UNLESS(std::filesystem::exists(nifti) && std::filesystem::exists(file),
                  "aal.nii.gz or its copy is absent");
  const Volume ours = read_all(*open_volume(file.string()));
  const Volume original = read_all(*open_volume(nifti));
  EXPECT_EQ(plain_bytes(ours), plain_bytes(original));
}

}  // namespace
}  // namespace cvr::volumes
