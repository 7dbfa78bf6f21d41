// Every decoder on the device: every cell of every level equals the label pyramid, over the sample
// volumes, by every path.
#include <gtest/gtest.h>

#include "codecs/registry.hpp"
#include "gpu/decode_probe.hpp"
#include "tests/gpu/drawing.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::gpu_tests {
namespace {

constexpr std::uint64_t kMostVoxels = 300000;  // the large sample volumes are for the CPU

class Decoders : public ::testing::TestWithParam<std::string> {};

void expect_pyramid(gpu::DecodeProbe& probe, gpu::DecodePath path, const volumes::Volume& volume,
                    unsigned levels, const std::string& what) {
  if (!probe.refuses(path).empty()) return;
  for (unsigned lod = 0; lod < levels; ++lod) {
    const auto found = probe.decode(path, lod);
    ASSERT_TRUE(found) << what << ": " << found.error().message;
    const volumes::Volume expected = lod == 0 ? volume : samples::label_pyramid(volume, lod);
    std::uint64_t wrong = 0;
    volumes::with_label_type(expected.info().type, [&]<class T>() {
      const auto labels = expected.voxels<T>();
      for (std::size_t i = 0; i < labels.size(); ++i) wrong += labels[i] != (*found)[i] ? 1 : 0;
    });
    EXPECT_EQ(wrong, 0u) << what << ", path " << static_cast<int>(path) << ", level " << lod;
  }
}

TEST_P(Decoders, EqualThePyramidOverTheZoo) {
  const codecs::Codec& codec = *codecs::find_codec(GetParam());
  unsigned checked = 0;
  for (const samples::SampleVolume& sample : samples::sample_volumes()) {
    if (sample.info.kind != volumes::VolumeKind::kLabels || !samples::accepts(codec, sample.info))
      continue;
    if (sample.info.extent.voxels() > kMostVoxels) continue;
    const volumes::Volume volume = sample.volume();
    const std::uint32_t brick = checked++ % 2 == 0 ? 32 : 16;
    const auto encoded = encode_for_gpu(volume, GetParam(), {}, brick);
    auto probe = gpu::DecodeProbe::make(device(), encoded->encoding, volume.info());
    ASSERT_TRUE(probe) << probe.error().message;
    for (const gpu::DecodePath path :
         {gpu::DecodePath::kCells, gpu::DecodePath::kBricks, gpu::DecodePath::kShared})
      expect_pyramid(**probe, path, volume, encoded->encoding.levels, sample.name);
  }
  EXPECT_GT(checked, 8u);
}

INSTANTIATE_TEST_SUITE_P(All, Decoders, ::testing::ValuesIn(gpu_codecs()), [](const auto& info) {
  std::string name = info.param;
  for (char& c : name) c = c == '-' ? '_' : c;
  return name;
});

}  // namespace
}  // namespace cvr::gpu_tests
