// A Vulkan driver with two devices, none of which can draw: one of Vulkan 1.1, and one of 1.3 that
// lacks features and has no queue for compute. The loader finds it by VK_DRIVER_FILES; it answers
// what choosing a device asks, and nothing else.
#include <vulkan/vk_icd.h>
#include <vulkan/vulkan.h>

#include <cstdlib>
#include <cstring>
#include <string_view>

namespace {

/// The loader writes its own table into the first word of what it hands on.
struct Handle {
  VK_LOADER_DATA loader{ICD_LOADER_MAGIC};
  const char* name = "";
  std::uint32_t version = 0;
};

Handle instance;
Handle old_device{{ICD_LOADER_MAGIC}, "Old", VK_MAKE_API_VERSION(0, 1, 1, 5)};
Handle bare_device{{ICD_LOADER_MAGIC}, "Bare", VK_MAKE_API_VERSION(0, 1, 3, 0)};

const Handle& handle_of(VkPhysicalDevice device) {
  return *reinterpret_cast<const Handle*>(device);
}

VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo*,
                                               const VkAllocationCallbacks*, VkInstance* made) {
  *made = reinterpret_cast<VkInstance>(&instance);
  return VK_SUCCESS;
}
VKAPI_ATTR void VKAPI_CALL destroy_instance(VkInstance, const VkAllocationCallbacks*) {}

VKAPI_ATTR VkResult VKAPI_CALL enumerate_version(std::uint32_t* version) {
  *version = VK_API_VERSION_1_3;
  return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL enumerate_devices(VkInstance, std::uint32_t* count,
                                                 VkPhysicalDevice* devices) {
  if (devices != nullptr) {
    devices[0] = reinterpret_cast<VkPhysicalDevice>(&old_device);
    devices[1] = reinterpret_cast<VkPhysicalDevice>(&bare_device);
  }
  *count = 2;
  return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL no_instance_extensions(const char*, std::uint32_t* count,
                                                      VkExtensionProperties*) {
  *count = 0;
  return VK_SUCCESS;
}
VKAPI_ATTR VkResult VKAPI_CALL no_device_extensions(VkPhysicalDevice, const char*,
                                                    std::uint32_t* count, VkExtensionProperties*) {
  *count = 0;
  return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL get_properties(VkPhysicalDevice device,
                                          VkPhysicalDeviceProperties* properties) {
  *properties = {};
  properties->apiVersion = handle_of(device).version;
  properties->deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  std::strcpy(properties->deviceName, handle_of(device).name);
}
VKAPI_ATTR void VKAPI_CALL get_properties2(VkPhysicalDevice device,
                                           VkPhysicalDeviceProperties2* properties) {
  get_properties(device, &properties->properties);
}
VKAPI_ATTR void VKAPI_CALL get_features(VkPhysicalDevice, VkPhysicalDeviceFeatures* features) {
  *features = {};
}
VKAPI_ATTR void VKAPI_CALL get_features2(VkPhysicalDevice, VkPhysicalDeviceFeatures2* features) {
  features->features = {};
  features->features.shaderInt64 = VK_TRUE;
}
VKAPI_ATTR void VKAPI_CALL get_memory(VkPhysicalDevice, VkPhysicalDeviceMemoryProperties* memory) {
  *memory = {};
}
VKAPI_ATTR void VKAPI_CALL get_queues(VkPhysicalDevice, std::uint32_t* count,
                                      VkQueueFamilyProperties* families) {
  if (families != nullptr)
    families[0] = {.queueFlags = VK_QUEUE_GRAPHICS_BIT, .queueCount = 1, .timestampValidBits = 64};
  *count = 1;
}
VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice, const VkDeviceCreateInfo*,
                                             const VkAllocationCallbacks*, VkDevice*) {
  return VK_ERROR_INITIALIZATION_FAILED;
}

/// What the loader demands of every driver and nothing here calls.
VKAPI_ATTR void VKAPI_CALL never_called() { std::abort(); }

PFN_vkVoidFunction find(std::string_view name) {
  const struct {
    std::string_view name;
    PFN_vkVoidFunction function;
  } known[] = {
      {"vkCreateInstance", reinterpret_cast<PFN_vkVoidFunction>(create_instance)},
      {"vkDestroyInstance", reinterpret_cast<PFN_vkVoidFunction>(destroy_instance)},
      {"vkEnumerateInstanceVersion", reinterpret_cast<PFN_vkVoidFunction>(enumerate_version)},
      {"vkEnumeratePhysicalDevices", reinterpret_cast<PFN_vkVoidFunction>(enumerate_devices)},
      {"vkEnumerateInstanceExtensionProperties",
       reinterpret_cast<PFN_vkVoidFunction>(no_instance_extensions)},
      {"vkEnumerateDeviceExtensionProperties",
       reinterpret_cast<PFN_vkVoidFunction>(no_device_extensions)},
      {"vkGetPhysicalDeviceProperties", reinterpret_cast<PFN_vkVoidFunction>(get_properties)},
      {"vkGetPhysicalDeviceProperties2", reinterpret_cast<PFN_vkVoidFunction>(get_properties2)},
      {"vkGetPhysicalDeviceFeatures", reinterpret_cast<PFN_vkVoidFunction>(get_features)},
      {"vkGetPhysicalDeviceFeatures2", reinterpret_cast<PFN_vkVoidFunction>(get_features2)},
      {"vkGetPhysicalDeviceMemoryProperties", reinterpret_cast<PFN_vkVoidFunction>(get_memory)},
      {"vkGetPhysicalDeviceQueueFamilyProperties",
       reinterpret_cast<PFN_vkVoidFunction>(get_queues)},
      {"vkCreateDevice", reinterpret_cast<PFN_vkVoidFunction>(create_device)},
      {"vkGetDeviceProcAddr", never_called},
      {"vkGetPhysicalDeviceFormatProperties", never_called},
      {"vkGetPhysicalDeviceImageFormatProperties", never_called},
      {"vkGetPhysicalDeviceSparseImageFormatProperties", never_called}};
  for (const auto& entry : known) {
    if (entry.name == name) return entry.function;
  }
  return nullptr;
}

}  // namespace

extern "C" {

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vk_icdGetInstanceProcAddr(VkInstance, const char* name) {
  return find(name);
}

VKAPI_ATTR VkResult VKAPI_CALL vk_icdNegotiateLoaderICDInterfaceVersion(std::uint32_t* version) {
  *version = *version < 5 ? *version : 5;
  return VK_SUCCESS;
}

}  // extern "C"
