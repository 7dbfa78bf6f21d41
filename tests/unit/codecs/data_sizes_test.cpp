// Exact sizes on the real volumes of the folder CVRBENCH_DATA. Whoever changes a size changes it
// here.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "codecs/codec.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/real_data.hpp"
#include "volumes/io/io.hpp"

namespace cvr::codecs {
namespace {

/// Published bytes of a codec with default parameters.
struct Row {
  const char* volume;
  Extent crop;  ///< the first voxels; empty: all
  const char* codec;
  std::uint64_t bytes;
};

constexpr Row kRows[] = {
    {"fib25_supervoxels", {}, "hdf5-gzip", 1612234},
    {"grains_growth_t0000", {}, "hdf5-gzip", 271963},
    {"human_atlas_allen", {}, "hdf5-gzip", 1391068},
    {"battery_nmc", {}, "hdf5-gzip", 2043875},
    {"frog_tissue", {}, "hdf5-gzip", 315590},
    {"connectomics_pinky40_a", {512, 512, 256}, "hdf5-gzip", 1763554},
    {"fib25_supervoxels", {}, "neuroglancer", 3556188},
    {"grains_growth_t0000", {}, "neuroglancer", 702752},
    {"human_atlas_allen", {}, "neuroglancer", 3295780},
    {"battery_nmc", {}, "neuroglancer", 4942448},
    {"frog_tissue", {}, "neuroglancer", 1047272},
    {"connectomics_pinky40_a", {512, 512, 256}, "neuroglancer", 3919480},
    {"fib25_supervoxels", {}, "compresso", 2684860},
    {"grains_growth_t0000", {}, "compresso", 438514},
    {"human_atlas_allen", {}, "compresso", 2537026},
    {"battery_nmc", {}, "compresso", 4320832},
    {"frog_tissue", {}, "compresso", 533495},
    {"connectomics_pinky40_a", {512, 512, 256}, "compresso", 1649392},
    {"grains_growth_t0000", {}, "compresso-lzma", 137828},
    {"frog_tissue", {}, "compresso-lzma", 138920},
};

/// The first voxels of another source.
class Crop final : public VolumeSource {
 public:
  Crop(const VolumeSource& source, const Extent& extent) : source_(source), info_(source.info()) {
    info_.extent = extent;
  }
  const VolumeInfo& info() const override { return info_; }
  void read(const volumes::Box& box, std::byte* out) const override { source_.read(box, out); }

 private:
  const VolumeSource& source_;
  VolumeInfo info_;
};

class DataSizes : public testing::TestWithParam<Row> {};

TEST_P(DataSizes, AreExact) {
  const char* folder = std::getenv("CVRBENCH_DATA");
  CVR_SKIP_UNLESS(folder != nullptr, "CVRBENCH_DATA names no folder of volumes");
  const Row& row = GetParam();
  const auto path = std::filesystem::path(folder) / (std::string(row.volume) + ".h5");
  CVR_SKIP_UNLESS(std::filesystem::exists(path), path << " is absent");
  const auto file = volumes::open_volume(path.string());
  const Crop crop(*file, row.crop.x != 0 ? row.crop : file->info().extent);
  const Volume volume = volumes::read_all(crop);
  const volumes::MemorySource source(volume);
  const Codec& codec = *find_codec(row.codec);
  const auto parameters = Parameters::parse(codec.parameters(), {}).value();
  const auto payload = codec.encode(source, parameters, 2);
  ASSERT_TRUE(payload) << payload.error().message;
  EXPECT_EQ(payload->published_bytes, row.bytes);
  const auto decoder = codec.open({volume.info(), parameters, payload->bytes.bytes()});
  ASSERT_TRUE(decoder) << decoder.error().message;
  volumes::CompareSink sink(source);
  ASSERT_TRUE((*decoder)->decode(0, 2, sink));
  EXPECT_EQ(sink.compared(), volume.extent().voxels());
  EXPECT_EQ(sink.mismatches(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Peers, DataSizes, testing::ValuesIn(kRows),
                         [](const testing::TestParamInfo<Row>& info) {
                           std::string name =
                               std::string(info.param.volume) + "_" + info.param.codec;
                           for (char& c : name) {
                             if (c == '-') c = '_';
                           }
                           return name;
                         });

}  // namespace
}  // namespace cvr::codecs
