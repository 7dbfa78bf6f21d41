// What the GPU tests share: one device for all of them, encoded volumes, and pictures by every way.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "codecs/container.hpp"
#include "gpu/caches/cache.hpp"
#include "gpu/renderer.hpp"
#include "volumes/volume.hpp"

namespace cvr::gpu_tests {

/// What CVRBENCH_DEVICE names, as gpu::DeviceOptions::choice; empty without it.
std::string device_choice();
/// The device of all tests: device_choice(); with the validation layer where CVRBENCH_VALIDATION is
/// set. Fails loudly where there is none.
gpu::Device& device();

/// An encoded volume, opened.
struct EncodedVolume {
  codecs::Buffer bytes;
  std::unique_ptr<codecs::OpenedFile> file;
  std::unique_ptr<codecs::Decoder> decoder;
  codecs::GpuEncoding encoding;
};
/// `parameters` as on the command line; `brick` for codecs without bricks of their own.
std::unique_ptr<EncodedVolume> encode_for_gpu(const volumes::Volume& volume,
                                              const std::string& codec,
                                              const std::vector<std::string>& parameters = {},
                                              std::uint32_t brick = 32);

volumes::Volume generate(const std::string& kind, const volumes::Extent& extent);

/// A scene that shows every second label, one in five half transparent.
gpu::Scene test_scene(gpu::Shading shading);
gpu::Camera corner_view(double distance = 1.5);

/// The settled picture; fails the test if it cannot be made.
gpu::Image draw(const EncodedVolume& encoded, const volumes::VolumeInfo& info,
                const gpu::Scene& scene, const gpu::Camera& camera,
                const gpu::RenderOptions& options, std::uint32_t samples = 1);

/// Every codec that a GPU decodes, by the registry.
std::vector<std::string> gpu_codecs();

}  // namespace cvr::gpu_tests
