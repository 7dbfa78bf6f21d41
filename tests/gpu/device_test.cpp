// A device that is lost: the error says which device, what ran and what happened; nothing hangs,
// and another device draws on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/gpu/drawing.hpp"

namespace cvr::gpu_tests {
namespace {

using testing::HasSubstr;

TEST(LostDevice, EndsAFrameWithAClearError) {
  const volumes::Volume volume = generate("cells", {48, 48, 48});
  const auto encoded = encode_for_gpu(volume, "csgvr-sb", {}, 16);
  const gpu::RenderOptions options{
      .access = "brick", .cache_bytes = gpu::kLeastCacheBytes, .width = 64, .height = 40};
  {
    bool is_lost = false;  // as a driver would report it
    gpu::Device lost({.choice = device_choice(), .after_wait = [&is_lost] {
                        gpu::check(is_lost ? VK_ERROR_DEVICE_LOST : VK_SUCCESS, "vkWaitForFences");
                      }});
    auto renderer = gpu::Renderer::make(lost, encoded->encoding, volume.info(), options).value();
    ASSERT_TRUE(renderer->set_scene(test_scene(gpu::Shading::kLocal)));
    EXPECT_TRUE(renderer->settle(corner_view()).complete);
    is_lost = true;
    for (int i = 0; i < 2; ++i) {  // a lost device stays lost
      try {
        renderer->render(corner_view());
        ADD_FAILURE() << "a frame was drawn";
      } catch (const gpu::DeviceError& error) {
        EXPECT_THAT(error.what(), HasSubstr(lost.report().name));
        EXPECT_THAT(error.what(),
                    HasSubstr("running the passes provision, assign, decode, render"));
        EXPECT_THAT(error.what(), HasSubstr("vkWaitForFences: device lost (-4)"));
      }
    }
    EXPECT_THROW(renderer->settle(corner_view()), gpu::DeviceError);
    EXPECT_THROW(renderer->clear_cache(), gpu::DeviceError);
    EXPECT_THROW((void)renderer->set_scene(test_scene(gpu::Shading::kLocal)), gpu::DeviceError);
    const auto other = encode_for_gpu(volume, "raw", {}, 16);
    EXPECT_THROW(
        {
          auto second =
              gpu::Renderer::make(lost, other->encoding, volume.info(), {.width = 8, .height = 8})
                  .value();
          (void)second->set_scene(test_scene(gpu::Shading::kLocal));
        },
        gpu::DeviceError);
  }
  draw(*encoded, volume.info(), test_scene(gpu::Shading::kLocal), corner_view(), options);
}

}  // namespace
}  // namespace cvr::gpu_tests
