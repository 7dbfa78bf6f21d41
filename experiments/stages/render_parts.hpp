// What the stages that draw labels and scalars have in common: cameras, rows of devices, memory and
// differences, samples of frames.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "experiments/stages/stage.hpp"
#include "gpu/caches/cache.hpp"
#include "gpu/image.hpp"
#include "gpu/scene.hpp"
#include "gpu/vulkan/device.hpp"

namespace cvr::experiments {

inline constexpr std::array kCheckedParts{
    0.0, 0.37, 0.81};  ///< of the camera path, where pictures are compared

inline Row describe_device(const gpu::Device& device) {
  const gpu::DeviceReport& report = device.report();
  return {
      {"name", report.name}, {"type", report.type}, {"driver", report.driver}, {"api", report.api}};
}

inline Row describe_memory(const std::vector<gpu::MemoryUse>& uses) {
  Row memory;
  memory["gpu_bytes"] = 0;
  std::uint64_t total = 0;
  for (const gpu::MemoryUse& use : uses) {
    memory["gpu_uses"][use.use] = use.bytes;
    total += use.bytes;
  }
  memory["gpu_bytes"] = total;
  return memory;
}

/// A PSNR has no number where the pictures are equal.
inline Row psnr_or_null(const gpu::ImageDifference& difference) {
  return difference.mse > 0 ? Row(difference.psnr) : Row(nullptr);
}

inline constexpr double kDifferenceGain =
    8;  ///< of kept pictures: an error of 12 % of full scale is white

/// Leaves a picture and its difference to what it should be as PNG files, whose names begin with
/// `spec.pictures`, and tells of them. Throws InputError.
inline Row keep_pictures(const WorkerSpec& spec, const gpu::Image& expected,
                         const gpu::Image& drawn) {
  const std::string picture = spec.pictures + ".png",
                    difference = spec.pictures + "-difference.png";
  gpu::write_png(picture, drawn.width, drawn.height, drawn.rgb8());
  gpu::write_png(difference, drawn.width, drawn.height,
                 gpu::difference_rgb8(expected, drawn, kDifferenceGain));
  const auto name = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  const gpu::ImageDifference error = gpu::compare(expected, drawn);
  return {{"picture", name(picture)},
          {"difference", name(difference)},
          {"gain", kDifferenceGain},
          {"psnr_db", psnr_or_null(error)},
          {"ssim", error.ssim}};
}

/// The samples of one frame: its time, and that of each of its passes as `passes` + name.
/// `incomplete`: pixels that met a placeholder.
template <class Frame>
void add_frame(const Frame& frame, std::uint32_t incomplete, const std::string& series,
               const std::string& passes, std::vector<Sample>& samples) {
  samples.push_back({series, frame.gpu_seconds, frame.host_seconds, incomplete});
  for (const gpu::PassTime& pass : frame.passes)
    samples.push_back({passes + pass.name, pass.seconds, 0, 0});
}

}  // namespace cvr::experiments
