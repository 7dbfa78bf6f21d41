// What images are drawn of, and how rows tell of devices, memory, kept images and frames.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "experiments/stages/stage.hpp"
#include "gpu/frame_renderer.hpp"
#include "gpu/image.hpp"
#include "gpu/vulkan/device.hpp"

namespace cvr::experiments {

inline constexpr std::array kCheckedParts{0.0, 0.37,
                                          0.81};  ///< of the camera path, where images are compared

/// An image of the scene from a part of its path.
struct Shot {
  double part = 0;
  std::uint32_t samples = 1;
  double lod_bias = 0;
};

/// Threads for what a cell does not measure.
unsigned cores();

Parts::Device describe_device(const gpu::Device& device);
Parts::Memory describe_memory(const std::vector<gpu::MemoryUse>& uses);

Named<std::uint64_t> counted(const gpu::FrameRenderer& renderer);

/// Leaves an image and its difference to what it should be as PNG files, whose names begin with
/// `spec.pictures`, and tells of them. Throws InputError.
Parts::Pictures keep_pictures(const WorkerSpec& spec, const gpu::Image& expected,
                              const gpu::Image& drawn);

/// The samples of one frame: its time, and that of each of its passes as `passes` + name.
void add_frame(const gpu::FrameResult& frame, const std::string& series, const std::string& passes,
               std::vector<Sample>& samples);

}  // namespace cvr::experiments
