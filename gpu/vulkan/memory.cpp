#include "gpu/vulkan/memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

namespace cvr::gpu {

namespace {

constexpr std::uint64_t kStagingBytes = std::uint64_t{64} << 20;

constexpr VkMemoryPropertyFlags kVisible =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;

/// What an allocation is for.
enum class Purpose { kDevice, kShared, kStaging };

/// A buffer with memory of its own, without an owner: released by release().
struct Allocation {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  bool visible = false;
};

/// Flags of memory types, the best first.
std::vector<VkMemoryPropertyFlags> wishes(const Device& device, Purpose purpose) {
  if (purpose == Purpose::kStaging) return {kVisible};
  if (purpose == Purpose::kShared) return {kLocal | kVisible, kLocal};
  const bool one_memory =
      device.report().type == "software" || device.report().type == "integrated";
  return one_memory ? std::vector{kLocal | kVisible, kLocal} : std::vector{kLocal};
}

std::optional<std::uint32_t> find_type(const VkPhysicalDeviceMemoryProperties& memory,
                                       std::uint32_t allowed, VkMemoryPropertyFlags flags) {
  for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    if ((allowed >> i & 1) != 0 && (memory.memoryTypes[i].propertyFlags & flags) == flags) return i;
  }
  return std::nullopt;
}

/// Errors: no room for it.
tl::expected<Allocation, VkResult> allocate(Device& device, std::uint64_t bytes, Purpose purpose) {
  Allocation a;
  const bool staging = purpose == Purpose::kStaging;
  const VkBufferUsageFlags transfer =
      VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  const VkBufferUsageFlags usage = staging ? transfer
                                           : transfer | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                                                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                                                 VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
  const VkBufferCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = usage};
  check(vkCreateBuffer(device.handle(), &info, nullptr, &a.buffer), "vkCreateBuffer");
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device.handle(), a.buffer, &needs);
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(device.physical(), &memory);
  const VkMemoryAllocateFlagsInfo flags{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
  VkResult result = VK_ERROR_FEATURE_NOT_PRESENT;
  for (const VkMemoryPropertyFlags wish : wishes(device, purpose)) {
    const auto type = find_type(memory, needs.memoryTypeBits, wish);
    if (!type) continue;
    const VkMemoryAllocateInfo request{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                       .pNext = staging ? nullptr : &flags,
                                       .allocationSize = needs.size,
                                       .memoryTypeIndex = *type};
    result = vkAllocateMemory(device.handle(), &request, nullptr, &a.memory);
    a.visible = (wish & kVisible) == kVisible;
    if (result == VK_SUCCESS) break;
    a.memory = VK_NULL_HANDLE;  // a failed allocation leaves anything there
  }
  if (result == VK_SUCCESS) result = vkBindBufferMemory(device.handle(), a.buffer, a.memory, 0);
  if (result == VK_SUCCESS) return a;
  vkDestroyBuffer(device.handle(), a.buffer, nullptr);
  if (a.memory != VK_NULL_HANDLE) vkFreeMemory(device.handle(), a.memory, nullptr);
  if (result != VK_ERROR_OUT_OF_DEVICE_MEMORY && result != VK_ERROR_OUT_OF_HOST_MEMORY)
    check(result, "vkAllocateMemory");
  return tl::unexpected(result);
}

Allocation allocate_staging(Device& device, std::uint64_t bytes) {
  const auto allocation = allocate(device, bytes, Purpose::kStaging);
  if (!allocation) check(allocation.error(), "vkAllocateMemory");
  return *allocation;
}

void release(Device& device, VkBuffer buffer, VkDeviceMemory memory) {
  vkDestroyBuffer(device.handle(), buffer, nullptr);
  vkFreeMemory(device.handle(), memory, nullptr);
}

std::byte* map(Device& device, VkDeviceMemory memory) {
  void* mapped = nullptr;
  check(vkMapMemory(device.handle(), memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
  return static_cast<std::byte*>(mapped);
}

/// Host memory for transfers, for the length of a block.
struct Staging {
  Staging(Device& d, std::uint64_t bytes)
      : device(d), allocation(allocate_staging(d, bytes)), window(map(d, allocation.memory)) {}
  ~Staging() { release(device, allocation.buffer, allocation.memory); }
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;
  Device& device;
  Allocation allocation;
  std::byte* window;
};

/// A command pool, for the length of a block.
struct Pool {
  explicit Pool(Device& d) : device(d) {
    const VkCommandPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                       .queueFamilyIndex = d.queue_family()};
    check(vkCreateCommandPool(d.handle(), &info, nullptr, &handle), "vkCreateCommandPool");
  }
  ~Pool() { vkDestroyCommandPool(device.handle(), handle, nullptr); }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  Device& device;
  VkCommandPool handle = VK_NULL_HANDLE;
};

/// Copies on the queue and waits.
void copy(Device& device, VkBuffer from, std::uint64_t from_at, VkBuffer to, std::uint64_t to_at,
          std::uint64_t bytes) {
  const Pool pool(device);
  const VkCommandBufferAllocateInfo allocate_info{
      .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
      .commandPool = pool.handle,
      .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
      .commandBufferCount = 1};
  VkCommandBuffer commands;
  check(vkAllocateCommandBuffers(device.handle(), &allocate_info, &commands),
        "vkAllocateCommandBuffers");
  const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
  const VkBufferCopy region{from_at, to_at, bytes};
  vkCmdCopyBuffer(commands, from, to, 1, &region);
  check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
  device.run(commands, fmt::format("a copy of {} bytes", bytes));
}

}  // namespace

volumes::Expected<DeviceBuffer> DeviceBuffer::make(Device& device, std::uint64_t bytes,
                                                   const std::string& use, Residency residency) {
  DeviceBuffer buffer;
  buffer.bytes_ = std::max<std::uint64_t>((bytes + 15) / 16 * 16, 16);
  if (buffer.bytes_ > device.limits().largest_allocation) {
    return volumes::fail(volumes::ErrorCode::kUnsupported,
                         fmt::format("{}: {} bytes exceed the device's largest allocation of {}",
                                     use, bytes, device.limits().largest_allocation));
  }
  const auto allocated = allocate(
      device, buffer.bytes_, residency == Residency::kShared ? Purpose::kShared : Purpose::kDevice);
  if (!allocated) {
    return volumes::fail(
        volumes::ErrorCode::kOutOfMemory,
        fmt::format("{}: {} bytes do not fit into the device's memory", use, bytes));
  }
  const Allocation& a = *allocated;
  buffer.device_ = &device;
  buffer.buffer_ = a.buffer;
  buffer.memory_ = a.memory;
  if (a.visible) buffer.mapped_ = map(device, a.memory);
  const VkBufferDeviceAddressInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                       .buffer = a.buffer};
  buffer.address_ = vkGetBufferDeviceAddress(device.handle(), &info);
  return buffer;
}

DeviceBuffer::~DeviceBuffer() {
  if (device_ != nullptr) release(*device_, buffer_, memory_);
}

void DeviceBuffer::swap(DeviceBuffer& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(buffer_, other.buffer_);
  std::swap(memory_, other.memory_);
  std::swap(mapped_, other.mapped_);
  std::swap(bytes_, other.bytes_);
  std::swap(address_, other.address_);
}

void DeviceBuffer::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  if (mapped_ != nullptr) {
    std::memcpy(mapped_ + offset, bytes.data(), bytes.size());
    return;
  }
  const Staging staging(*device_, std::min<std::uint64_t>(bytes.size(), kStagingBytes));
  for (std::uint64_t at = 0; at < bytes.size(); at += kStagingBytes) {
    const std::uint64_t part = std::min<std::uint64_t>(kStagingBytes, bytes.size() - at);
    std::memcpy(staging.window, bytes.data() + at, part);
    copy(*device_, staging.allocation.buffer, 0, buffer_, offset + at, part);
  }
}

void DeviceBuffer::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (bytes.empty()) return;
  if (mapped_ != nullptr) {
    std::memcpy(bytes.data(), mapped_ + offset, bytes.size());
    return;
  }
  const Staging staging(*device_, std::min<std::uint64_t>(bytes.size(), kStagingBytes));
  for (std::uint64_t at = 0; at < bytes.size(); at += kStagingBytes) {
    const std::uint64_t part = std::min<std::uint64_t>(kStagingBytes, bytes.size() - at);
    copy(*device_, buffer_, offset + at, staging.allocation.buffer, 0, part);
    std::memcpy(bytes.data() + at, staging.window, part);
  }
}

}  // namespace cvr::gpu
