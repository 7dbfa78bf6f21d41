#include "gpu/allocations.hpp"

namespace cvr::gpu {

volumes::Expected<void> Allocations::make(DeviceBuffer& buffer, std::uint64_t bytes,
                                          const std::string& use, Residency residency) {
  auto made = DeviceBuffer::make(device_, bytes, use, residency);
  if (!made) return tl::unexpected(made.error());
  buffer = std::move(*made);
  uses_.push_back({use, buffer.bytes()});
  return {};
}

volumes::Expected<void> Allocations::upload(std::span<codecs::GpuBuffer> pieces,
                                            std::uint64_t* addresses) {
  for (codecs::GpuBuffer& piece : pieces) {
    DeviceBuffer buffer;
    if (auto made = make(buffer, piece.bytes.size(), "encoding: " + piece.use); !made) return made;
    buffer.write(0, piece.bytes);
    *addresses++ = buffer.address();
    encoded_.push_back(std::move(buffer));
    piece = {};
  }
  return {};
}

}  // namespace cvr::gpu
