#include "gpu/vulkan/commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>

namespace cvr::gpu {

Kernel::Kernel(Device& device, const Commands& commands, const KernelSource& source)
    : device_(device) {
  const auto start = std::chrono::steady_clock::now();
  const std::vector<std::uint32_t> words = compile_kernel(source);
  const VkShaderModuleCreateInfo module_info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                             .codeSize = words.size() * 4,
                                             .pCode = words.data()};
  VkShaderModule module;
  check(vkCreateShaderModule(device.handle(), &module_info, nullptr, &module),
        "vkCreateShaderModule");
  const VkComputePipelineCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
      .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = module,
                .pName = "main"},
      .layout = commands.layout()};
  const VkResult result =
      vkCreateComputePipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
  vkDestroyShaderModule(device.handle(), module, nullptr);
  check(result, "vkCreateComputePipelines");
  seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Kernel::~Kernel() { vkDestroyPipeline(device_.handle(), pipeline_, nullptr); }

Commands::Commands(Device& device, std::uint32_t uniform_bytes) : device_(device) {
  auto uniforms = DeviceBuffer::make(device, uniform_bytes, "uniforms", Residency::kShared);
  if (!uniforms) throw DeviceError(uniforms.error().message);
  uniforms_ = std::move(*uniforms);
  const VkDescriptorSetLayoutBinding binding{.binding = 0,
                                             .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                             .descriptorCount = 1,
                                             .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
  const VkDescriptorSetLayoutCreateInfo set_info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
      .bindingCount = 1,
      .pBindings = &binding};
  check(vkCreateDescriptorSetLayout(device.handle(), &set_info, nullptr, &set_layout_),
        "vkCreateDescriptorSetLayout");
  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(PushWords)};
  const VkPipelineLayoutCreateInfo layout_info{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
      .setLayoutCount = 1,
      .pSetLayouts = &set_layout_,
      .pushConstantRangeCount = 1,
      .pPushConstantRanges = &range};
  check(vkCreatePipelineLayout(device.handle(), &layout_info, nullptr, &layout_),
        "vkCreatePipelineLayout");
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1};
  const VkDescriptorPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = 1,
                                             .pPoolSizes = &size};
  check(vkCreateDescriptorPool(device.handle(), &pool_info, nullptr, &descriptors_),
        "vkCreateDescriptorPool");
  const VkDescriptorSetAllocateInfo set_allocate{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
      .descriptorPool = descriptors_,
      .descriptorSetCount = 1,
      .pSetLayouts = &set_layout_};
  check(vkAllocateDescriptorSets(device.handle(), &set_allocate, &set_),
        "vkAllocateDescriptorSets");
  const VkDescriptorBufferInfo buffer_info{uniforms_.handle(), 0, VK_WHOLE_SIZE};
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = set_,
                                   .descriptorCount = 1,
                                   .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                   .pBufferInfo = &buffer_info};
  vkUpdateDescriptorSets(device.handle(), 1, &write, 0, nullptr);
  const VkCommandPoolCreateInfo commands_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                              .queueFamilyIndex = device.queue_family()};
  check(vkCreateCommandPool(device.handle(), &commands_info, nullptr, &pool_),
        "vkCreateCommandPool");
  const VkCommandBufferAllocateInfo allocate{
      .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
      .commandPool = pool_,
      .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
      .commandBufferCount = 1};
  check(vkAllocateCommandBuffers(device.handle(), &allocate, &commands_),
        "vkAllocateCommandBuffers");
  const VkQueryPoolCreateInfo queries_info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                           .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                           .queryCount = kMostPasses + 1};
  check(vkCreateQueryPool(device.handle(), &queries_info, nullptr, &queries_), "vkCreateQueryPool");
}

Commands::~Commands() {
  vkDeviceWaitIdle(device_.handle());
  vkDestroyQueryPool(device_.handle(), queries_, nullptr);
  vkDestroyCommandPool(device_.handle(), pool_, nullptr);
  vkDestroyDescriptorPool(device_.handle(), descriptors_, nullptr);
  vkDestroyPipelineLayout(device_.handle(), layout_, nullptr);
  vkDestroyDescriptorSetLayout(device_.handle(), set_layout_, nullptr);
}

void Commands::begin(std::span<const std::byte> uniforms) {
  uniforms_.write(0, uniforms);
  check(vkResetCommandPool(device_.handle(), pool_, 0), "vkResetCommandPool");
  vkResetQueryPool(device_.handle(), queries_, 0, kMostPasses + 1);
  passes_.clear();
  const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  check(vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer");
}

void Commands::timestamp() {
  vkCmdWriteTimestamp2(commands_, VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT, queries_,
                       static_cast<std::uint32_t>(passes_.size()));
}

void Commands::pass(const std::string& name) {
  if (passes_.size() == kMostPasses) throw std::logic_error("too many passes in a frame");
  timestamp();
  passes_.push_back(name);
}

void Commands::barrier() {
  const VkMemoryBarrier2 memory{
      .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
      .srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
      .srcAccessMask = VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT,
      .dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT |
                      VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
      .dstAccessMask = VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_WRITE_BIT |
                       VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_TRANSFER_READ_BIT |
                       VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT};
  const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                              .memoryBarrierCount = 1,
                              .pMemoryBarriers = &memory};
  vkCmdPipelineBarrier2(commands_, &info);
}

void Commands::bind(const Kernel& kernel, const PushWords& push) {
  barrier();
  vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.handle());
  vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0,
                          nullptr);
  vkCmdPushConstants(commands_, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, push.data());
}

void Commands::dispatch(const Kernel& kernel, std::uint32_t groups, const PushWords& push) {
  bind(kernel, push);
  vkCmdDispatch(commands_, groups, 1, 1);
}

void Commands::dispatch_indirect(const Kernel& kernel, const DeviceBuffer& groups,
                                 std::uint64_t offset, const PushWords& push) {
  bind(kernel, push);
  vkCmdDispatchIndirect(commands_, groups.handle(), offset);
}

void Commands::fill(const DeviceBuffer& buffer, std::uint64_t offset, std::uint64_t bytes,
                    std::uint32_t word) {
  barrier();
  vkCmdFillBuffer(commands_, buffer.handle(), offset, bytes, word);
}

std::vector<PassTime> Commands::submit() {
  timestamp();
  const VkMemoryBarrier2 memory{
      .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
      .srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
      .srcAccessMask = VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT,
      .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
      .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT};
  const VkDependencyInfo dependency{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                    .memoryBarrierCount = 1,
                                    .pMemoryBarriers = &memory};
  vkCmdPipelineBarrier2(commands_, &dependency);
  check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
  device_.run(commands_,
              passes_.empty() ? "no pass" : fmt::format("the passes {}", fmt::join(passes_, ", ")));
  std::vector<std::uint64_t> ticks(passes_.size() + 1);
  check(vkGetQueryPoolResults(device_.handle(), queries_, 0,
                              static_cast<std::uint32_t>(ticks.size()), ticks.size() * 8,
                              ticks.data(), 8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "vkGetQueryPoolResults");
  const std::uint64_t mask = device_.timestamp_bits() >= 64
                                 ? ~std::uint64_t{0}
                                 : (std::uint64_t{1} << device_.timestamp_bits()) - 1;
  std::vector<PassTime> times;
  for (std::size_t i = 0; i < passes_.size(); ++i) {
    times.push_back({passes_[i], 1e-9 * device_.timestamp_period() *
                                     static_cast<double>((ticks[i + 1] - ticks[i]) & mask)});
  }
  return times;
}

}  // namespace cvr::gpu
