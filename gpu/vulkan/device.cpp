#include "gpu/vulkan/device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace cvr::gpu {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
constexpr std::uint64_t kWaitNanoseconds = std::uint64_t{600} * 1000 * 1000 * 1000;

VKAPI_ATTR VkBool32 VKAPI_CALL collect_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                               VkDebugUtilsMessageTypeFlagsEXT,
                                               const VkDebugUtilsMessengerCallbackDataEXT* data,
                                               void* user) {
  static_cast<std::vector<std::string>*>(user)->emplace_back(data->pMessage);
  return VK_FALSE;
}

const char* name_of(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of device memory";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "initialisation failed";
    case VK_ERROR_DEVICE_LOST:
      return "device lost";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "extension not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "no compatible driver";
    case VK_TIMEOUT:
      return "time-out";
    default:
      return "error";
  }
}

VkInstance create_instance(const DeviceOptions& options, std::vector<std::string>* messages) {
  const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                      .pApplicationName = "cvrbench",
                                      .apiVersion = VK_API_VERSION_1_3};
  VkDebugUtilsMessengerCreateInfoEXT debug{
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                         VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                     VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
      .pfnUserCallback = collect_message,
      .pUserData = messages};
  std::vector<VkValidationFeatureEnableEXT> enabled{
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  if (options.gpu_assisted) {
    enabled.push_back(VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_EXT);
    enabled.push_back(VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_RESERVE_BINDING_SLOT_EXT);
  }
  const VkValidationFeaturesEXT features{
      .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
      .pNext = &debug,
      .enabledValidationFeatureCount = static_cast<std::uint32_t>(enabled.size()),
      .pEnabledValidationFeatures = enabled.data()};
  const std::array extensions{VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                              VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                            .pApplicationInfo = &application};
  if (options.validation) {
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    info.enabledExtensionCount = extensions.size();
    info.ppEnabledExtensionNames = extensions.data();
  }
  VkInstance instance = VK_NULL_HANDLE;
  check(vkCreateInstance(&info, nullptr, &instance), "vkCreateInstance");
  return instance;
}

/// The features that the kernels need, chained, so that they are asked for and enabled from one
/// place.
struct Features {
  VkPhysicalDeviceVulkan13Features v13{.sType =
                                           VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceVulkan12Features v12{.sType =
                                           VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceFeatures2 core{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};

  Features() { link(); }
  Features(const Features& other) : v13(other.v13), v12(other.v12), core(other.core) { link(); }

  struct Need {
    VkBool32& flag;
    const char* name;
  };
  std::vector<Need> needs() {
    return {{core.features.shaderInt64, "shaderInt64"},
            {v12.shaderBufferInt64Atomics, "shaderBufferInt64Atomics"},
            {v12.bufferDeviceAddress, "bufferDeviceAddress"},
            {v12.scalarBlockLayout, "scalarBlockLayout"},
            {v12.vulkanMemoryModel, "vulkanMemoryModel"},
            {v12.vulkanMemoryModelDeviceScope, "vulkanMemoryModelDeviceScope"},
            {v12.hostQueryReset, "hostQueryReset"},
            {v13.synchronization2, "synchronization2"},
            {v13.maintenance4, "maintenance4"}};
  }

 private:
  void link() {
    core.pNext = &v12;
    v12.pNext = &v13;
    v13.pNext = nullptr;
  }
};

struct Candidate {
  VkPhysicalDevice physical;
  DeviceReport report;
  VkDriverId driver{};
  std::uint32_t family = 0, timestamp_bits = 0;
};

std::string type_of(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "software";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated";
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual";
    default:
      return "other";
  }
}

std::string version_text(std::uint32_t version) {
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                     VK_API_VERSION_PATCH(version));
}

void find_queue(Candidate& candidate) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(candidate.physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(candidate.physical, &count, families.data());
  for (std::uint32_t i = 0; i < count; ++i) {
    if ((families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0 || families[i].timestampValidBits == 0)
      continue;
    candidate.family = i;
    candidate.timestamp_bits = families[i].timestampValidBits;
    return;
  }
  candidate.report.rejected.emplace_back("no compute queue with timestamps");
}

Candidate examine(VkPhysicalDevice physical, std::uint32_t index) {
  Candidate candidate{.physical = physical, .report = {.index = index}};
  VkPhysicalDeviceSubgroupProperties subgroup{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceMaintenance3Properties maintenance{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES, .pNext = &subgroup};
  VkPhysicalDeviceMaintenance4Properties buffers{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES, .pNext = &maintenance};
  VkPhysicalDeviceDriverProperties driver{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, .pNext = &buffers};
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                         .pNext = &driver};
  vkGetPhysicalDeviceProperties2(physical, &properties);
  candidate.driver = driver.driverID;
  DeviceReport& report = candidate.report;
  report.name = properties.properties.deviceName;
  report.type = type_of(properties.properties.deviceType);
  report.api = version_text(properties.properties.apiVersion);
  report.driver = fmt::format("{} {}", driver.driverName, driver.driverInfo);
  report.shared_memory = properties.properties.limits.maxComputeSharedMemorySize;
  report.subgroup = subgroup.subgroupSize;
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(physical, &memory);
  for (std::uint32_t i = 0; i < memory.memoryHeapCount; ++i) {
    if ((memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0)
      report.memory = std::max<std::uint64_t>(report.memory, memory.memoryHeaps[i].size);
  }
  // maxMemoryAllocationSize is what a driver promises (often 4 GiB), not what it refuses: graphics
  // cards give more in one piece. llvmpipe means its 2 GiB.
  report.largest_allocation = maintenance.maxMemoryAllocationSize;
  if (properties.properties.deviceType != VK_PHYSICAL_DEVICE_TYPE_CPU &&
      properties.properties.apiVersion >= VK_API_VERSION_1_3)
    report.largest_allocation = std::max<std::uint64_t>(
        report.largest_allocation, std::min<std::uint64_t>(buffers.maxBufferSize, report.memory));
  if (properties.properties.apiVersion < VK_API_VERSION_1_3) {
    report.rejected.push_back(fmt::format("Vulkan {}, expected 1.3", report.api));
    return candidate;
  }
  constexpr VkSubgroupFeatureFlags kSubgroups =
      VK_SUBGROUP_FEATURE_ARITHMETIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT;
  if ((subgroup.supportedOperations & kSubgroups) != kSubgroups ||
      (subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) == 0) {
    report.rejected.emplace_back("no arithmetic and ballots of subgroups in compute shaders");
  }
  Features features;
  vkGetPhysicalDeviceFeatures2(physical, &features.core);
  for (const auto& need : features.needs()) {
    if (need.flag == VK_FALSE)
      report.rejected.push_back(fmt::format("lacks the feature {}", need.name));
  }
  find_queue(candidate);
  return candidate;
}

std::vector<Candidate> examine_all(VkInstance instance) {
  std::uint32_t count = 0;
  check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> devices(count);
  if (count > 0)
    check(vkEnumeratePhysicalDevices(instance, &count, devices.data()),
          "vkEnumeratePhysicalDevices");
  std::vector<Candidate> candidates;
  for (std::uint32_t i = 0; i < count; ++i) candidates.push_back(examine(devices[i], i));
  return candidates;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool is_chosen(const DeviceReport& report, const std::string& choice) {
  if (choice.empty() || choice == std::to_string(report.index)) return true;
  const bool number = choice.find_first_not_of("0123456789") == std::string::npos;
  return !number && (lower(report.name).find(lower(choice)) != std::string::npos ||
                     report.type == lower(choice));
}

const Candidate& choose(std::vector<Candidate>& candidates, const std::string& choice) {
  if (choice.empty()) {
    std::stable_partition(candidates.begin(), candidates.end(),
                          [](const Candidate& c) { return c.report.type == "software"; });
  }
  std::string list;
  for (Candidate& candidate : candidates) {
    DeviceReport& report = candidate.report;
    const bool chosen = is_chosen(report, choice);
    if (chosen && report.rejected.empty()) return candidate;
    std::vector<std::string> reasons = report.rejected;
    if (!chosen) reasons.push_back(fmt::format("is not '{}'", choice));
    list += fmt::format("; device {} ({}, {}): ", report.index, report.name, report.type);
    for (std::size_t i = 0; i < reasons.size(); ++i) list += (i == 0 ? "" : ", ") + reasons[i];
  }
  if (candidates.empty())
    list =
        "; there is no Vulkan driver on this machine (the package mesa-vulkan-drivers holds "
        "lavapipe)";
  throw DeviceError("no Vulkan device that can draw" + list);
}

}  // namespace

void check(VkResult result, const char* call) {
  if (result != VK_SUCCESS)
    throw DeviceError(fmt::format("{}: {} ({})", call, name_of(result), static_cast<int>(result)));
}

std::vector<DeviceReport> list_devices() {
  VkInstance instance = VK_NULL_HANDLE;
  try {
    instance = create_instance({}, nullptr);
  } catch (const DeviceError&) {
    return {};  // the loader refuses to make an instance where no driver is installed
  }
  std::vector<DeviceReport> reports;
  for (const Candidate& candidate : examine_all(instance)) reports.push_back(candidate.report);
  vkDestroyInstance(instance, nullptr);
  return reports;
}

Device::Device(const DeviceOptions& options) : after_wait_(options.after_wait) {
  try {
    instance_ = create_instance(options, &messages_);
  } catch (const DeviceError& error) {
    throw DeviceError(fmt::format(
        "no Vulkan device that can draw; {} (the package mesa-vulkan-drivers holds lavapipe{})",
        error.what(), options.validation ? ", vulkan-validationlayers the validation layer" : ""));
  }
  if (options.validation) {
    const VkDebugUtilsMessengerCreateInfoEXT info{
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
        .pfnUserCallback = collect_message,
        .pUserData = &messages_};
    const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
    check(create(instance_, &info, nullptr, &messenger_), "vkCreateDebugUtilsMessengerEXT");
  }
  try {
    auto candidates = examine_all(instance_);
    const Candidate& chosen = choose(candidates, options.choice);
    physical_ = chosen.physical;
    report_ = chosen.report;
    family_ = chosen.family;
    timestamp_bits_ = chosen.timestamp_bits;
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical_, &properties);
    period_ = static_cast<double>(properties.limits.timestampPeriod);
    const bool llvmpipe = chosen.driver == VK_DRIVER_ID_MESA_LLVMPIPE;
    limits_ = {std::min(report_.largest_allocation, options.largest_allocation),
               report_.memory,
               report_.shared_memory,
               report_.subgroup,
               properties.limits.maxComputeWorkGroupCount[0],
               llvmpipe ? 65535u : UINT32_MAX,
               llvmpipe};
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                        .queueFamilyIndex = family_,
                                        .queueCount = 1,
                                        .pQueuePriorities = &priority};
    Features features;
    for (const auto& need : features.needs()) need.flag = VK_TRUE;
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                  .pNext = &features.core,
                                  .queueCreateInfoCount = 1,
                                  .pQueueCreateInfos = &queue};
    check(vkCreateDevice(physical_, &info, nullptr, &device_), "vkCreateDevice");
    vkGetDeviceQueue(device_, family_, 0, &queue_);
    const VkFenceCreateInfo fence{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    check(vkCreateFence(device_, &fence, nullptr, &fence_), "vkCreateFence");
  } catch (...) {
    close();
    throw;
  }
}

Device::~Device() { close(); }

void Device::run(VkCommandBuffer commands, const std::string& what) {
  const VkSubmitInfo info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                          .commandBufferCount = 1,
                          .pCommandBuffers = &commands};
  try {
    check(vkResetFences(device_, 1, &fence_), "vkResetFences");
    check(vkQueueSubmit(queue_, 1, &info, fence_), "vkQueueSubmit");
    const VkResult waited = vkWaitForFences(device_, 1, &fence_, VK_TRUE, kWaitNanoseconds);
    if (after_wait_) after_wait_();
    check(waited, "vkWaitForFences");
  } catch (const DeviceError& error) {
    throw DeviceError(fmt::format("device {} ({}, {}), running {}: {}", report_.index, report_.name,
                                  report_.type, what, error.what()));
  }
}

void Device::close() {
  if (fence_ != VK_NULL_HANDLE) vkDestroyFence(device_, fence_, nullptr);
  if (device_ != VK_NULL_HANDLE) vkDestroyDevice(device_, nullptr);
  if (messenger_ != VK_NULL_HANDLE) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(instance_, messenger_, nullptr);
  }
  if (instance_ != VK_NULL_HANDLE) vkDestroyInstance(instance_, nullptr);
}

}  // namespace cvr::gpu
