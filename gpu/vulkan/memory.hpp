// Device memory that kernels reach by address.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "gpu/vulkan/device.hpp"
#include "volumes/error.hpp"

namespace cvr::gpu {

/// Where a buffer lies.
enum class Residency : std::uint8_t {
  kDevice,  ///< device-local; mapped where the device's memory is the host's (lavapipe, integrated devices)
  kShared,  ///< what the host writes or reads every frame: device-local and mapped where there is such memory, else as kDevice
};

/// One allocation with its buffer.
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  /// `bytes` is rounded up to 16; 0 makes a buffer of 16. kUnsupported for what exceeds the
  /// device's largest allocation, naming the limit; kOutOfMemory where the device has no room.
  /// Throws DeviceError for other failures.
  static volumes::Expected<DeviceBuffer> make(Device& device, std::uint64_t bytes,
                                              const std::string& use,
                                              Residency residency = Residency::kDevice);
  DeviceBuffer(DeviceBuffer&& other) noexcept { swap(other); }
  DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
    swap(other);
    return *this;
  }
  ~DeviceBuffer();

  std::uint64_t address() const { return address_; }
  std::uint64_t bytes() const { return bytes_; }
  VkBuffer handle() const { return buffer_; }
  /// Copies to or from the device; no kernel may be running.
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  void swap(DeviceBuffer& other) noexcept;

  Device* device_ = nullptr;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  std::byte* mapped_ = nullptr;
  std::uint64_t bytes_ = 0, address_ = 0;
};

}  // namespace cvr::gpu
