// Every codec by every access mode and shading mode draws the picture of the CPU renderer, label by
// label and colour by colour; what does not go together is refused with a reason.
#include <gtest/gtest.h>

#include <map>

#include "gpu/reference/reference.hpp"
#include "tests/gpu/drawing.hpp"

namespace cvr::gpu_tests {
namespace {

constexpr std::uint32_t kWidth = 96, kHeight = 56, kBrick = 16;

struct Combination {
  std::string codec, access;
  gpu::Shading shading;
};

std::string name_of_combination(const ::testing::TestParamInfo<Combination>& info) {
  std::string name = info.param.codec + "_" + info.param.access + "_" +
                     std::string(gpu::name_of(info.param.shading));
  for (char& c : name) c = c == '-' ? '_' : c;
  return name;
}

std::vector<Combination> combinations() {
  std::vector<Combination> all;
  for (const std::string& codec : gpu_codecs()) {
    for (const gpu::CacheTraits& cache : gpu::all_caches()) {
      for (const gpu::Shading shading : gpu::kShadings)
        all.push_back({codec, std::string(cache.id), shading});
    }
  }
  return all;
}

class Pictures : public ::testing::TestWithParam<Combination> {
 protected:
  static const volumes::Volume& volume() {
    static const volumes::Volume kVolume = generate("neurites", {60, 49, 71});
    return kVolume;
  }
  static const gpu::ReferenceRenderer& reference() {
    static const gpu::ReferenceRenderer kReference(volume(), kBrick, 2);
    return kReference;
  }
  static const EncodedVolume& encoded(const std::string& codec) {
    static std::map<std::string, std::unique_ptr<EncodedVolume>> made;
    auto& slot = made[codec];
    if (!slot) slot = encode_for_gpu(volume(), codec, {}, kBrick);
    return *slot;
  }
};

TEST_P(Pictures, EqualTheReference) {
  const auto& [codec, access, shading] = GetParam();
  const EncodedVolume& volume_encoded = encoded(codec);
  const gpu::CacheTraits& cache = *gpu::find_cache(access);
  gpu::Scene scene = test_scene(shading);
  scene.width = kWidth;
  scene.height = kHeight;
  const gpu::RenderOptions options{.access = access,
                                   .cache_bytes = gpu::kLeastCacheBytes,
                                   .shading = shading,
                                   .width = kWidth,
                                   .height = kHeight};
  if (const std::string reason = cache.refuses(volume_encoded.encoding, device().limits());
      !reason.empty()) {
    const auto renderer =
        gpu::Renderer::make(device(), volume_encoded.encoding, volume().info(), options);
    ASSERT_FALSE(renderer);
    EXPECT_EQ(renderer.error().code, volumes::ErrorCode::kUnsupported);
    EXPECT_NE(renderer.error().message.find(reason), std::string::npos);
    return;
  }
  const gpu::Camera camera = corner_view(1.3);
  const std::uint32_t samples = shading == gpu::Shading::kAo ? 3 : 1;
  const gpu::Image image = draw(volume_encoded, volume().info(), scene, camera, options, samples);
  const gpu::Image truth = reference().render(scene, camera, 0, samples);
  const gpu::LabelCheck labels = gpu::check_labels(reference(), scene, camera, truth, image);
  EXPECT_EQ(labels.differing, labels.near_ties);
  EXPECT_LE(labels.near_ties, 1u);
  const gpu::ImageDifference difference = gpu::compare(truth, image);
  EXPECT_TRUE(difference.mse == 0 || difference.psnr > 60) << difference.psnr << " dB";
}

INSTANTIATE_TEST_SUITE_P(All, Pictures, ::testing::ValuesIn(combinations()), name_of_combination);

TEST(PicturesOfManyVoxels, OfEachKindEqualTheReference) {
  for (const std::string kind : {"cells", "fibers", "neurites", "atlas"}) {
    const volumes::Volume volume = generate(kind, {90, 101, 77});
    const gpu::ReferenceRenderer reference(volume, 32, 2);
    gpu::Scene scene = test_scene(gpu::Shading::kShadow);
    scene.width = 160;
    scene.height = 90;
    const auto encoded = encode_for_gpu(volume, "csgvr-sb");
    for (const double distance : {0.3, 0.9, 6.0}) {
      for (const std::string access : {"none", "voxel-es", "brick"}) {
        const gpu::Camera camera = corner_view(distance);
        const gpu::Image image =
            draw(*encoded, volume.info(), scene, camera,
                 {.access = access, .shading = scene.shading, .width = 160, .height = 90});
        const gpu::Image truth = reference.render(scene, camera);
        const gpu::LabelCheck labels = gpu::check_labels(reference, scene, camera, truth, image);
        EXPECT_EQ(labels.differing, labels.near_ties)
            << kind << " " << access << " at " << distance;
        EXPECT_LT(gpu::compare(truth, image).mse,
                  1e-4)  // a shadow's edge may fall on a pixel's ray
            << kind << " " << access << " at " << distance;
      }
    }
  }
}

TEST(PicturesOfManyVoxels, RaysByRouletteAreThoseOfTheReference) {
  const volumes::Volume volume = generate("neurites", {60, 49, 71});
  const gpu::ReferenceRenderer reference(volume, 32, 2);
  gpu::Scene scene = test_scene(gpu::Shading::kAo);
  scene.width = 160;
  scene.height = 90;
  scene.ao_roulette = true;
  const auto encoded = encode_for_gpu(volume, "csgvr-sb");
  const gpu::Camera camera = corner_view(1.3);
  const gpu::Image truth = reference.render(scene, camera, 0, 3);
  scene.ao_roulette = false;
  EXPECT_GT(gpu::compare(truth, reference.render(scene, camera, 0, 3)).mse, 0);
  scene.ao_roulette = true;
  for (const std::string access : {"none", "voxel-es", "brick-coop"}) {
    const gpu::Image image = draw(*encoded, volume.info(), scene, camera,
                                  {.access = access,
                                   .shading = gpu::Shading::kAo,
                                   .width = scene.width,
                                   .height = scene.height},
                                  3);
    const gpu::LabelCheck labels = gpu::check_labels(reference, scene, camera, truth, image);
    EXPECT_EQ(labels.differing, labels.near_ties) << access;
    const gpu::ImageDifference difference = gpu::compare(truth, image);
    EXPECT_TRUE(difference.mse == 0 || difference.psnr > 60) << access << difference.psnr << " dB";
  }
}

TEST(PicturesOfManyVoxels, BricksOf64AreDecodedInParts) {
  const volumes::Volume volume = generate("cells", {130, 70, 66});
  const gpu::ReferenceRenderer reference(volume, 64, 2);
  gpu::Scene scene = test_scene(gpu::Shading::kLocal);
  scene.width = 96;
  scene.height = 54;
  const gpu::Camera camera = corner_view(0.8);
  const gpu::Image truth = reference.render(scene, camera);
  for (const std::string codec : {"raw", "csgvr-sb", "csgv-rans"}) {
    const auto encoded = encode_for_gpu(volume, codec, {}, 64);
    for (const std::string access : {"none", "brick", "brick-coop"}) {
      if (!gpu::find_cache(access)->refuses(encoded->encoding, device().limits()).empty()) continue;
      const gpu::Image image =
          draw(*encoded, volume.info(), scene, camera,
               {.access = access, .width = scene.width, .height = scene.height});
      EXPECT_EQ(gpu::compare(truth, image).labels, 0u) << codec << " " << access;
    }
  }
}

}  // namespace
}  // namespace cvr::gpu_tests
