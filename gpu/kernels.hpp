// How kernels are put together: the frame's text, the shared text, a codec's decoder. What follows
// is the kernel's own.
#pragma once

#include <string>

#include "codecs/gpu_encoding.hpp"
#include "gpu/vulkan/compiler.hpp"
#include "gpu/vulkan/device.hpp"

namespace cvr::gpu {

/// The beginning of every kernel of an encoding: levels, and the text that reads the frame.
KernelSource frame_kernel(const std::string& name, const codecs::GpuEncoding& encoding,
                          bool instrumented = false);

/// The shared text and the decoder with its constants, as the device bears them best, to be
/// appended.
KernelSource decoder_text(const Device& device, const codecs::GpuEncoding& encoding);

}  // namespace cvr::gpu
