// A Vulkan device for compute: chosen from a list in which each rejected device says why.
//
// Needed: Vulkan 1.3 with 64-bit integers, their buffer atomics, buffer device addresses, scalar
// block layout and the Vulkan memory model; a compute queue with timestamps. No window system, no
// graphics. All errors here are errors of the environment.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace cvr::gpu {

/// No usable device, device lost, out of device memory: what the program cannot mend.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A device of this machine, usable or not.
struct DeviceReport {
  std::uint32_t index = 0;
  std::string name, type, driver, api;  ///< type: software, integrated, discrete, virtual, other
  std::uint64_t memory = 0;             ///< bytes of the largest device-local heap
  std::uint64_t largest_allocation = 0;
  std::uint32_t shared_memory = 0;    ///< bytes a workgroup
  std::uint32_t subgroup = 0;         ///< invocations
  std::vector<std::string> rejected;  ///< reasons; empty: usable
};

/// All devices; empty where there is no Vulkan driver at all. Throws DeviceError if the loader
/// fails.
std::vector<DeviceReport> list_devices();

struct DeviceOptions {
  std::string
      choice;  ///< an index, or a part of a name or type, in any case; empty: the first software device, else the first usable
  bool validation = false;    ///< the Khronos validation layer: core, synchronisation
  bool gpu_assisted = false;  ///< and its GPU-assisted checks
  std::uint64_t largest_allocation = UINT64_MAX;  ///< bytes; a smaller device than there is
  /// Called when the device has ended what was submitted; may throw DeviceError, as a driver would
  /// that has lost it.
  std::function<void()> after_wait = {};
};

struct DeviceLimits {
  std::uint64_t largest_allocation;
  std::uint64_t memory;
  std::uint32_t shared_memory;
  std::uint32_t subgroup;
  std::uint32_t groups;  ///< workgroups along x of one dispatch
  /// Iterations of all loops of an invocation together; the driver silently ends loops beyond.
  /// Mesa's llvmpipe has this bound (LP_MAX_TGSI_LOOP_ITERATIONS); no Vulkan query tells it.
  /// UINT32_MAX: none known.
  std::uint32_t loop_iterations;
  /// Loads at addresses that differ between the invocations of a subgroup are made one after the
  /// other, as llvmpipe does: what is read again and again is better held.
  bool serial_gathers;
};

class Device {
 public:
  /// Throws DeviceError that lists all devices and why each was rejected.
  explicit Device(const DeviceOptions& options = {});
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceReport& report() const { return report_; }
  const DeviceLimits& limits() const { return limits_; }
  /// Warnings and errors of the validation layer so far.
  const std::vector<std::string>& validation_messages() const { return messages_; }

  VkDevice handle() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  std::uint32_t queue_family() const { return family_; }
  /// Submits a command buffer and waits until it is done; one at a time. Throws DeviceError that
  /// names the device and `what`, the work in words, where the device is lost, memory runs out or
  /// nothing ends for ten minutes.
  void run(VkCommandBuffer commands, const std::string& what);

  double timestamp_period() const { return period_; }  ///< ns a tick
  std::uint32_t timestamp_bits() const { return timestamp_bits_; }

 private:
  void close();

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;  ///< of run()
  std::function<void()> after_wait_;
  std::uint32_t family_ = 0, timestamp_bits_ = 64;
  double period_ = 1;
  DeviceReport report_;
  DeviceLimits limits_{};
  std::vector<std::string> messages_;
};

/// Throws DeviceError that names the call and the result.
void check(VkResult result, const char* call);

}  // namespace cvr::gpu
