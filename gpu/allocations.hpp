// The device memory of a renderer: buffers with what each is for, so that a table can say where
// memory goes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "codecs/gpu_encoding.hpp"
#include "gpu/vulkan/memory.hpp"

namespace cvr::gpu {

struct MemoryUse {
  std::string use;
  std::uint64_t bytes;
};

class Allocations {
 public:
  explicit Allocations(Device& device) : device_(device) {}
  /// Makes `buffer` and notes it. Errors: see DeviceBuffer::make.
  volumes::Expected<void> make(DeviceBuffer& buffer, std::uint64_t bytes, const std::string& use,
                               Residency residency = Residency::kDevice);
  /// Uploads a codec's buffers and keeps them; addresses[i] becomes that of the i-th. The pieces
  /// are empty afterwards, so that the host's copies can go.
  volumes::Expected<void> upload(std::span<codecs::GpuBuffer> pieces, std::uint64_t* addresses);
  const std::vector<MemoryUse>& uses() const { return uses_; }

 private:
  Device& device_;
  std::vector<DeviceBuffer> encoded_;
  std::vector<MemoryUse> uses_;
};

}  // namespace cvr::gpu
