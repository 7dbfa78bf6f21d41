// The Khronos validation layer (core and synchronisation checks) is silent while every codec draws by
// every access mode that serves it, each shading mode among them.
#include <gtest/gtest.h>

#include "codecs/registry.hpp"
#include "gpu/scalars/reference.hpp"
#include "gpu/scalars/renderer.hpp"
#include "tests/gpu/drawing.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::gpu_tests {
namespace {

constexpr std::uint32_t kWidth = 40, kHeight = 24;

void expect_silence(const gpu::Device& device) {
  for (const std::string& message : device.validation_messages()) ADD_FAILURE() << message;
}

class Validation : public testing::TestWithParam<std::string> {};

TEST_P(Validation, TheLayerIsSilentWhereLabelsAreDrawn) {
  gpu::Device device({device_choice(), true, false});
  const volumes::Volume volume = generate("neurites", {48, 40, 36});
  const auto encoded = encode_for_gpu(volume, GetParam(), {}, 16);
  const auto draw_one = [&](const gpu::CacheTraits& cache, gpu::Shading shading) {
    auto renderer = gpu::Renderer::make(device, encoded->encoding, volume.info(),
                                        {.access = std::string(cache.id),
                                         .cache_bytes = gpu::kLeastCacheBytes,
                                         .shading = shading,
                                         .width = kWidth,
                                         .height = kHeight,
                                         .instrumented = shading == gpu::Shading::kAo});
    ASSERT_TRUE(renderer) << renderer.error().message;
    const auto ok = (*renderer)->set_scene(test_scene(shading));
    ASSERT_TRUE(ok) << ok.error().message;
    (*renderer)->settle(corner_view(), 2);
    (*renderer)->read_image();
  };
  // Shadings differ in the marcher alone, which modes and codecs extend alike: each mode has one of
  // them, the first of the registry all.
  std::size_t turn = 0, modes = 0;
  for (const gpu::CacheTraits& cache : gpu::all_caches()) {
    if (!cache.labels || !cache.refuses(encoded->encoding, device.limits()).empty()) continue;
    ++modes;
    if (GetParam() == gpu_codecs().front()) {
      for (const gpu::Shading shading : gpu::kShadings) draw_one(cache, shading);
    } else {
      draw_one(cache, gpu::kShadings[turn++ % gpu::kShadings.size()]);
    }
  }
  EXPECT_GT(modes, 0u);
  expect_silence(device);
}

INSTANTIATE_TEST_SUITE_P(All, Validation, testing::ValuesIn(gpu_codecs()), [](const auto& info) {
  return samples::test_name(*codecs::find_codec(info.param), {});
});

TEST(ValidationOfScalars, TheLayerIsSilent) {
  gpu::Device device({device_choice(), true, false});
  const volumes::Volume volume = samples::sample("ramp_of_scalars_u8").volume();
  gpu::Scene scene;
  scene.width = kWidth;
  scene.height = kHeight;
  scene.transfer = {{0.2, {30, 60, 200}, 0}, {0.8, {250, 250, 230}, 0.3}};
  unsigned drawn = 0;
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    if (!codec->traits().gpu_scalars) continue;
    const auto parameters = codecs::Parameters::parse(codec->parameters(), {}).value();
    const auto encoded =
        codecs::encode(*codec, volumes::MemorySource(volume), parameters, 2).value();
    const auto file = codecs::open_file(encoded.bytes.bytes()).value();
    const auto decoder = codecs::open_decoder(file).value();
    for (const gpu::CacheTraits& cache : gpu::all_caches()) {
      if (!cache.scalars) continue;
      auto renderer = gpu::ScalarRenderer::make(
          device, decoder->gpu_samples(0).value(), volume.info(), gpu::value_range(volume),
          {.access = std::string(cache.id), .width = kWidth, .height = kHeight});
      ASSERT_TRUE(renderer) << renderer.error().message;
      ASSERT_TRUE((*renderer)->set_scene(scene));
      (*renderer)->render(corner_view());
      (*renderer)->read_image();
      ++drawn;
    }
  }
  EXPECT_GE(drawn, 2u);
  expect_silence(device);
}

}  // namespace
}  // namespace cvr::gpu_tests
