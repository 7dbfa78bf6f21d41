// Kernels and the recording of their work: every pass between two timestamps, every pass after a
// full memory barrier.
//
// Kernels have one uniform block (set 0, binding 0) that a frame writes before it records, and four
// words of push constants.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gpu/vulkan/compiler.hpp"
#include "gpu/vulkan/memory.hpp"

namespace cvr::gpu {

using PushWords = std::array<std::uint32_t, 4>;

class Commands;

/// A compiled compute pipeline.
class Kernel {
 public:
  Kernel(Device& device, const Commands& commands, const KernelSource& source);
  ~Kernel();
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;
  VkPipeline handle() const { return pipeline_; }
  double compile_seconds() const { return seconds_; }  ///< GLSL to SPIR-V to the device's code

 private:
  Device& device_;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  double seconds_ = 0;
};

struct PassTime {
  std::string name;
  double seconds = 0;
};

/// Records one submission at a time.
class Commands {
 public:
  /// `uniform_bytes` of the block that all kernels see.
  Commands(Device& device, std::uint32_t uniform_bytes);
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  VkPipelineLayout layout() const { return layout_; }
  void begin(std::span<const std::byte> uniforms);
  /// All that is recorded until the next pass() or submit() is timed under this name.
  void pass(const std::string& name);
  void dispatch(const Kernel& kernel, std::uint32_t groups, const PushWords& push = {});
  void dispatch_indirect(const Kernel& kernel, const DeviceBuffer& groups, std::uint64_t offset,
                         const PushWords& push = {});
  /// Sets words of a buffer.
  void fill(const DeviceBuffer& buffer, std::uint64_t offset, std::uint64_t bytes,
            std::uint32_t word);
  /// Submits, waits, and gives the time of each pass. Throws DeviceError.
  std::vector<PassTime> submit();

 private:
  void barrier();
  void bind(const Kernel& kernel, const PushWords& push);
  void timestamp();

  static constexpr std::uint32_t kMostPasses = 31;
  Device& device_;
  DeviceBuffer uniforms_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkDescriptorPool descriptors_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkQueryPool queries_ = VK_NULL_HANDLE;
  std::vector<std::string> passes_;
};

}  // namespace cvr::gpu
