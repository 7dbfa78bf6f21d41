// Caches under pressure: too small for the view, hardly large enough for anything, changed scenes,
// counters.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/gpu/drawing.hpp"

namespace cvr::gpu_tests {
namespace {

constexpr std::uint32_t kWidth = 128, kHeight = 72;

gpu::RenderOptions options(const std::string& access, std::uint64_t cache_bytes,
                           bool instrumented = false) {
  return {.access = access,
          .cache_bytes = cache_bytes,
          .width = kWidth,
          .height = kHeight,
          .instrumented = instrumented};
}

gpu::Scene opaque_scene() {
  gpu::Scene scene;
  scene.materials = {{.modulus = 2, .remainder = 1}};
  scene.width = kWidth;
  scene.height = kHeight;
  return scene;
}

std::uint64_t counter(const gpu::Counters& counters, const std::string& name) {
  const auto found =
      std::ranges::find(counters, name, &std::pair<std::string, std::uint64_t>::first);
  return found == counters.end() ? UINT64_MAX : found->second;
}

TEST(Caches, AMebibyteEndsInTheExactPicture) {
  const volumes::Volume volume = generate("cells", {128, 128, 128});
  const auto encoded = encode_for_gpu(volume, "csgvr-sb");
  gpu::Scene scene = opaque_scene();
  scene.materials = {{.first = 1}};
  const gpu::Camera camera = corner_view(1.2);
  const gpu::Image truth = draw(*encoded, volume.info(), scene, camera, options("none", 0));
  for (const std::string access :
       {"voxel", "voxel-es", "brick", "brick-coop", "brick-coop-shared"}) {
    const gpu::Image image =
        draw(*encoded, volume.info(), scene, camera, options(access, gpu::kLeastCacheBytes));
    EXPECT_TRUE(gpu::compare(truth, image).identical()) << access;
  }
}

TEST(Caches, WhatOneRayNeedsMustFit) {
  const volumes::Volume volume = generate("fibers", {256, 32, 32});
  const auto encoded = encode_for_gpu(volume, "csgv-nibble", {}, 32);
  auto renderer = gpu::Renderer::make(device(), encoded->encoding, volume.info(),
                                      options("brick", gpu::kLeastCacheBytes + 1000))
                      .value();
  gpu::Scene scene = opaque_scene();
  scene.materials = {{.opacity = 0.01}};  // rays along the volume pass all its bricks
  ASSERT_TRUE(renderer->set_scene(scene));
  const gpu::Settled settled = renderer->settle({{0.55, 0, 0}, {0, 0, 0}, {0, 1, 0}, 3});
  EXPECT_TRUE(settled.complete) << "eight bricks fit";
  auto longer = generate("fibers", {384, 32, 32});
  const auto longer_encoded = encode_for_gpu(longer, "csgv-nibble", {}, 32);
  renderer = gpu::Renderer::make(device(), longer_encoded->encoding, longer.info(),
                                 options("brick", gpu::kLeastCacheBytes))
                 .value();
  ASSERT_TRUE(renderer->set_scene(scene));
  const gpu::Settled stuck = renderer->settle({{0.55, 0, 0}, {0, 0, 0}, {0, 1, 0}, 3});
  EXPECT_FALSE(stuck.complete);
  EXPECT_GT(stuck.incomplete, 0u);
}

TEST(Caches, ACacheBelowOneBrickIsRefused) {
  const volumes::Volume volume = generate("cells", {70, 70, 70});
  const auto encoded = encode_for_gpu(volume, "csgv-nibble", {}, 64);
  const auto renderer = gpu::Renderer::make(device(), encoded->encoding, volume.info(),
                                            options("brick", (1u << 20) - 1));
  ASSERT_FALSE(renderer);
  EXPECT_NE(renderer.error().message.find("1 MiB"), std::string::npos) << renderer.error().message;
}

TEST(Caches, BrickCachesAreOneFrameLate) {
  const volumes::Volume volume = generate("cells", {96, 96, 96});
  const auto encoded = encode_for_gpu(volume, "csgv-rans");
  auto renderer =
      gpu::Renderer::make(device(), encoded->encoding, volume.info(), options("brick", 64u << 20))
          .value();
  ASSERT_TRUE(renderer->set_scene(opaque_scene()));
  const gpu::FrameResult first = renderer->render(corner_view());
  EXPECT_GT(first.incomplete, 0u);
  EXPECT_EQ(first.cache.decoded, 0u);
  gpu::FrameResult later;
  for (int i = 0; i < 8 && (i == 0 || later.incomplete > 0); ++i)
    later = renderer->render(corner_view());
  EXPECT_EQ(later.incomplete, 0u);
  renderer->clear_cache();
  EXPECT_GT(renderer->render(corner_view()).incomplete, 0u);
}

TEST(Caches, AVoxelCacheAnswersTheSecondFrame) {
  const volumes::Volume volume = generate("cells", {64, 64, 64});
  const auto encoded = encode_for_gpu(volume, "csgvr");
  auto renderer = gpu::Renderer::make(device(), encoded->encoding, volume.info(),
                                      options("voxel", 16u << 20, true))
                      .value();
  ASSERT_TRUE(renderer->set_scene(opaque_scene()));
  renderer->render(corner_view());
  const gpu::Counters cold = renderer->read_counters();
  EXPECT_GT(counter(cold, "cache_misses"), 1000u);
  EXPECT_EQ(counter(cold, "cache_misses"), counter(cold, "cells_decoded"));
  EXPECT_EQ(counter(cold, "rays"), std::uint64_t{kWidth} * kHeight);
  renderer->clear_counters();
  renderer->render(corner_view());
  const gpu::Counters warm = renderer->read_counters();
  EXPECT_LT(counter(warm, "cache_misses"), counter(cold, "cache_misses") / 20);
  EXPECT_LT(counter(warm, "words_touched"),
            counter(cold, "words_touched") / 4);  // not those that check the cache
  EXPECT_EQ(counter(warm, "wrong_labels"), 0u);
}

TEST(Caches, AFullTableLosesEntriesAndStaysRight) {
  const volumes::Volume volume = generate("fibers", {160, 160, 160});
  const auto encoded = encode_for_gpu(volume, "raw");
  const gpu::Scene scene = opaque_scene();
  auto renderer = gpu::Renderer::make(device(), encoded->encoding, volume.info(),
                                      options("voxel", gpu::kLeastCacheBytes, true))
                      .value();
  ASSERT_TRUE(renderer->set_scene(scene));
  for (int i = 0; i < 4; ++i) renderer->render(corner_view(1.0 + 0.05 * i));
  const gpu::Counters counters = renderer->read_counters();
  EXPECT_GT(counter(counters, "cache_ejections"), 1000u);
  EXPECT_GT(counter(counters, "cache_losses"), 100u);
  EXPECT_EQ(counter(counters, "wrong_labels"), 0u);
  const gpu::Image truth =
      draw(*encoded, volume.info(), scene, corner_view(1.15), options("none", 0));
  EXPECT_TRUE(gpu::compare(truth, renderer->read_image()).identical());
}

TEST(Caches, AChangedSceneForgetsWhatWasInvisible) {
  const volumes::Volume volume = generate("neurites", {80, 80, 80});
  const auto encoded = encode_for_gpu(volume, "csgvr-sb");
  auto renderer =
      gpu::Renderer::make(device(), encoded->encoding, volume.info(), options("voxel-es", 8u << 20))
          .value();
  gpu::Scene scene = opaque_scene();
  ASSERT_TRUE(renderer->set_scene(scene));
  renderer->render(corner_view());
  scene.materials = {{.modulus = 2, .remainder = 0}};
  ASSERT_TRUE(renderer->set_scene(scene));
  renderer->render(corner_view());
  const gpu::Image truth = draw(*encoded, volume.info(), scene, corner_view(), options("none", 0));
  EXPECT_TRUE(gpu::compare(truth, renderer->read_image()).identical());
}

TEST(Caches, EmptySpaceBitsSpareDecoding) {
  const volumes::Volume volume = generate("fibers", {96, 96, 96});
  const auto encoded = encode_for_gpu(volume, "csgvr-sb");
  std::uint64_t skips = 0, entries[2] = {};
  for (const bool empty_space : {false, true}) {
    auto renderer =
        gpu::Renderer::make(device(), encoded->encoding, volume.info(),
                            options(empty_space ? "voxel-es" : "voxel", 32u << 20, true))
            .value();
    gpu::Scene scene = opaque_scene();
    scene.materials = {{.first = 1, .last = 9}};
    ASSERT_TRUE(renderer->set_scene(scene));
    renderer->render(corner_view());
    renderer->render(corner_view());
    const gpu::Counters counters = renderer->read_counters();
    entries[empty_space ? 1 : 0] = counter(counters, "cache_hits");
    if (empty_space) skips = counter(counters, "empty_space_skips");
  }
  EXPECT_GT(skips, 1000u);
  EXPECT_LT(entries[1], entries[0] / 2);
}

TEST(Caches, EmptySpaceAsPublishedIsWrongAtCoarseLevelsAlone) {
  const volumes::Volume volume = generate("cells", {96, 96, 96});
  const auto encoded = encode_for_gpu(volume, "csgvr-sb");
  const auto wrong_after_moving = [&](const std::string& access, double lod_bias) {
    gpu::Scene scene = opaque_scene();
    scene.materials = {{.modulus = 4, .remainder = 1}};
    scene.lod_bias = lod_bias;
    auto renderer =
        gpu::Renderer::make(device(), encoded->encoding, volume.info(), options(access, 32u << 20))
            .value();
    EXPECT_TRUE(renderer->set_scene(scene));
    std::uint64_t wrong = 0;
    for (const double distance : {0.3, 0.6, 1.0, 1.6, 2.5, 4.0}) {
      renderer->render(corner_view(distance));
      const gpu::Image truth =
          draw(*encoded, volume.info(), scene, corner_view(distance), options("none", 0));
      wrong += gpu::compare(truth, renderer->read_image()).labels;
    }
    return wrong;
  };
  EXPECT_EQ(wrong_after_moving("voxel-es", 0), 0u);
  EXPECT_EQ(wrong_after_moving("voxel-es-paper", -32), 0u);
  EXPECT_GT(wrong_after_moving("voxel-es-paper", 0), 0u);
}

TEST(Caches, EmptySpaceAsPublishedDecodesWholeBlocks) {
  const volumes::Volume volume = generate("fibers", {96, 96, 96});
  const auto encoded = encode_for_gpu(volume, "csgvr");
  std::map<std::string, std::uint64_t> decoded;
  for (const std::string access : {"voxel-es", "voxel-es-paper"}) {
    auto renderer = gpu::Renderer::make(device(), encoded->encoding, volume.info(),
                                        options(access, 32u << 20, true))
                        .value();
    gpu::Scene scene = opaque_scene();
    scene.materials = {{.first = 1, .last = 9}};
    ASSERT_TRUE(renderer->set_scene(scene));
    renderer->render(corner_view());
    const gpu::Counters counters = renderer->read_counters();
    decoded[access] = counter(counters, "cells_decoded");
    EXPECT_GT(counter(counters, "empty_space_marks"), 100u);
    EXPECT_EQ(counter(counters, "wrong_labels"), 0u);
  }
  EXPECT_GT(decoded["voxel-es-paper"], decoded["voxel-es"]);
}

TEST(Caches, MemoryIsAccountedFor) {
  const volumes::Volume volume = generate("cells", {64, 64, 64});
  const auto encoded = encode_for_gpu(volume, "csgvr");
  auto renderer =
      gpu::Renderer::make(device(), encoded->encoding, volume.info(), options("voxel", 3u << 20))
          .value();
  std::uint64_t cache = 0, encoding = 0, uploaded = 0;
  for (const gpu::MemoryUse& use : renderer->memory()) {
    if (use.use == "cache") cache = use.bytes;
    if (use.use.starts_with("encoding")) encoding += use.bytes;
  }
  for (const auto& buffer : encoded->encoding.buffers)
    uploaded += (buffer.bytes.size() + 15) / 16 * 16;
  EXPECT_EQ(cache, 3u << 20);
  EXPECT_EQ(encoding, uploaded);
}

}  // namespace
}  // namespace cvr::gpu_tests
