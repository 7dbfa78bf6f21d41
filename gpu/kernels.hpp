// How kernels are put together: the frame, a codec's decoder, the access mode, the kernel. Each of
// these shader sources includes what it needs of the shared ones.
#pragma once

#include <string>

#include "codecs/gpu_encoding.hpp"
#include "gpu/vulkan/compiler.hpp"
#include "gpu/vulkan/device.hpp"

namespace cvr::gpu {

/// The beginning of every kernel of an encoding: levels, and the source that reads the frame.
KernelSource frame_kernel(const std::string& name, const codecs::GpuEncoding& encoding,
                          bool instrumented = false);

/// The decoder that the encoding names, with its constants, as the device bears it best; to be
/// appended.
KernelSource decoder_source(const Device& device, const codecs::GpuEncoding& encoding);

}  // namespace cvr::gpu
