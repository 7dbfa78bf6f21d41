#include "experiments/stages/render_parts.hpp"

#include <algorithm>
#include <filesystem>
#include <thread>

#include "experiments/stages/render_errors.hpp"

namespace cvr::experiments {

namespace {

constexpr double kDifferenceGain = 8;  ///< of kept images: an error of 12 % of full scale is white

}  // namespace

unsigned cores() { return std::max(1u, std::thread::hardware_concurrency()); }

Parts::Device describe_device(const gpu::Device& device) {
  const gpu::DeviceReport& report = device.report();
  return {std::string(report.name), std::string(report.type), std::string(report.driver),
          std::string(report.api)};
}

Parts::Memory describe_memory(const std::vector<gpu::MemoryUse>& uses) {
  Parts::Memory memory;
  Named<std::uint64_t>& by_use = memory.gpu_uses.emplace();
  std::uint64_t total = 0;
  for (const gpu::MemoryUse& use : uses) {
    by_use[use.use] = use.bytes;
    total += use.bytes;
  }
  memory.gpu_bytes = total;
  return memory;
}

Named<std::uint64_t> counted(const gpu::FrameRenderer& renderer) {
  Named<std::uint64_t> work;
  for (const auto& [name, count] : renderer.read_counters()) work[name] = count;
  return work;
}

Parts::Pictures keep_pictures(const WorkerSpec& spec, const gpu::Image& expected,
                              const gpu::Image& drawn) {
  const std::string picture = spec.pictures + ".png",
                    difference = spec.pictures + "-difference.png";
  gpu::write_png(picture, drawn.width, drawn.height, drawn.rgb8());
  gpu::write_png(difference, drawn.width, drawn.height,
                 gpu::difference_rgb8(expected, drawn, kDifferenceGain));
  const auto name = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  const ImageErrors errors = errors_of(expected, drawn);
  return {name(picture), name(difference), kDifferenceGain, psnr_of(errors.mean_mse()),
          errors.mean_ssim()};
}

void add_frame(const gpu::FrameResult& frame, const std::string& series, const std::string& passes,
               std::vector<Sample>& samples) {
  samples.push_back({series, frame.gpu_seconds, frame.host_seconds, frame.incomplete});
  for (const gpu::PassTime& pass : frame.passes)
    samples.push_back({passes + pass.name, pass.seconds, 0, 0});
}

}  // namespace cvr::experiments
