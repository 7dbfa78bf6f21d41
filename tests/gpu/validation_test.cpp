// The Khronos validation layer (core and synchronisation checks) is silent while every access mode
// and shading mode draws.
#include <gtest/gtest.h>

#include "tests/gpu/drawing.hpp"

namespace cvr::gpu_tests {
namespace {

std::vector<std::string> messages_of(bool gpu_assisted) {
  gpu::Device device({device_choice(), true, gpu_assisted});
  const volumes::Volume volume = generate("neurites", {48, 40, 36});
  for (const std::string codec : {"raw", "csgvr-sb", "csgv-rans"}) {
    const auto encoded = encode_for_gpu(volume, codec, {}, 16);
    for (const gpu::CacheTraits& cache : gpu::all_caches()) {
      if (!cache.refuses(encoded->encoding, device.limits()).empty()) continue;
      for (const gpu::Shading shading : gpu::kShadings) {
        auto renderer = gpu::Renderer::make(device, encoded->encoding, volume.info(),
                                            {.access = std::string(cache.id),
                                             .cache_bytes = gpu::kLeastCacheBytes,
                                             .shading = shading,
                                             .width = 40,
                                             .height = 24,
                                             .instrumented = shading == gpu::Shading::kAo});
        if (!renderer) return {renderer.error().message};
        if (auto ok = (*renderer)->set_scene(test_scene(shading)); !ok) return {ok.error().message};
        (*renderer)->settle(corner_view(), 2);
        (*renderer)->read_image();
      }
    }
  }
  return device.validation_messages();
}

TEST(Validation, TheLayerIsSilent) {
  for (const std::string& message : messages_of(false)) ADD_FAILURE() << message;
}

}  // namespace
}  // namespace cvr::gpu_tests
