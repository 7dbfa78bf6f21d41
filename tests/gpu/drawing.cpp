#include "tests/gpu/drawing.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "codecs/registry.hpp"
#include "volumes/generators/generator.hpp"

namespace cvr::gpu_tests {

std::string device_choice() {
  const char* choice = std::getenv("CVRBENCH_DEVICE");
  return choice == nullptr ? "" : choice;
}

gpu::Device& device() {
  static gpu::Device kDevice({device_choice(), std::getenv("CVRBENCH_VALIDATION") != nullptr,
                              std::getenv("CVRBENCH_GPU_ASSISTED") != nullptr});
  return kDevice;
}

std::unique_ptr<EncodedVolume> encode_for_gpu(const volumes::Volume& volume, const std::string& id,
                                              const std::vector<std::string>& parameters,
                                              std::uint32_t brick) {
  const codecs::Codec& codec = *codecs::find_codec(id);
  std::vector<std::string> given = parameters;
  for (const auto& spec : codec.parameters()) {
    if (spec.name == "brick") given.push_back("brick=" + std::to_string(brick));
  }
  auto parsed = codecs::Parameters::parse(codec.parameters(), given);
  if (!parsed) throw std::runtime_error(parsed.error().message);
  auto encoded = codecs::encode(codec, volumes::MemorySource(volume), *parsed, 2);
  if (!encoded) throw std::runtime_error(encoded.error().message);
  auto result = std::make_unique<EncodedVolume>();
  result->bytes = std::move(encoded->bytes);
  result->file =
      std::make_unique<codecs::OpenedFile>(codecs::open_file(result->bytes.bytes()).value());
  result->decoder = codecs::open_decoder(*result->file).value();
  auto encoding = result->decoder->gpu_encoding(brick, 2);
  if (!encoding) throw std::runtime_error(encoding.error().message);
  result->encoding = std::move(*encoding);
  return result;
}

volumes::Volume generate(const std::string& kind, const volumes::Extent& extent) {
  const auto source = volumes::make_generator(kind, extent, 7, {}, 2);
  volumes::Volume volume(source->info());
  source->read({{0, 0, 0}, extent}, volume.data());
  return volume;
}

gpu::Scene test_scene(gpu::Shading shading) {
  gpu::Scene scene;
  scene.shading = shading;
  scene.materials = {{.modulus = 5, .remainder = 2, .opacity = 0.4},
                     {.modulus = 2, .remainder = 1}};
  return scene;
}

gpu::Camera corner_view(double distance) {
  return {{0.5 * distance, 0.45 * distance, 0.74 * distance}, {0, 0, 0}, {0, 1, 0}, 45};
}

gpu::Image draw(const EncodedVolume& encoded, const volumes::VolumeInfo& info,
                const gpu::Scene& scene, const gpu::Camera& camera,
                const gpu::RenderOptions& options, std::uint32_t samples) {
  auto renderer = gpu::Renderer::make(device(), encoded.encoding, info, options);
  if (!renderer) {
    ADD_FAILURE() << renderer.error().message;
    return {};
  }
  if (auto ok = (*renderer)->set_scene(scene); !ok) ADD_FAILURE() << ok.error().message;
  const gpu::Settled settled = (*renderer)->settle(camera, samples);
  EXPECT_TRUE(settled.complete) << settled.incomplete << " pixels are left after " << settled.frames
                                << " frames";
  return (*renderer)->read_image();
}

std::vector<std::string> gpu_codecs() {
  std::vector<std::string> ids;
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    if (codec->traits().gpu_decodable) ids.emplace_back(codec->traits().id);
  }
  return ids;
}

}  // namespace cvr::gpu_tests
