#include "gpu/kernels.hpp"

#include <fmt/format.h>

namespace cvr::gpu {

KernelSource frame_kernel(const std::string& name, const codecs::GpuEncoding& encoding,
                          bool instrumented) {
  KernelSource source{.name = name};
  source.definitions = {{"CVR_BRICK_SHIFT", fmt::format("{}u", encoding.levels - 1)},
                        {"CVR_LEVELS", fmt::format("{}u", encoding.levels)}};
  if (instrumented) source.definitions.emplace_back("CVR_INSTRUMENTED", "1");
  source.files = {"shaders/render/frame.glsl"};
  return source;
}

KernelSource decoder_source(const Device& device, const codecs::GpuEncoding& encoding) {
  KernelSource source;
  if (device.limits().serial_gathers) source.definitions.emplace_back("CVR_HOLD_HEADERS", "1");
  for (const auto& [name, value] : encoding.constants)
    source.definitions.emplace_back(name, std::to_string(value));
  source.files.push_back(fmt::format("shaders/decode/{}.glsl", encoding.decoder));
  return source;
}

}  // namespace cvr::gpu
