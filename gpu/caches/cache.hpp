// The contract of access modes: how the ray marcher gets at labels. One file and one shader source
// per mode, one line in caches.cpp.
//
// A mode declares what it needs of the codec and the device, owns its device memory, adds its
// source to the marcher's kernel and records its passes before the rendering pass of each frame. It knows
// no codec by name.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codecs/gpu_encoding.hpp"
#include "gpu/allocations.hpp"
#include "gpu/frame.hpp"
#include "gpu/vulkan/commands.hpp"
#include "volumes/error.hpp"
#include "volumes/volume.hpp"

namespace cvr::gpu {

/// What a mode is built on; outlives it.
struct CacheSetting {
  Device& device;
  Commands& commands;
  const codecs::GpuEncoding& encoding;
  volumes::VolumeInfo info;
  volumes::Extent grid;       ///< bricks along each axis
  std::uint64_t cache_bytes;  ///< what the cache may take
  KernelSource decoder;       ///< the codec's, with its definitions
  bool instrumented;
};

/// What happened in the passes of one frame.
struct CacheReport {
  std::uint32_t requested = 0;  ///< bricks wanted and not there
  std::uint32_t decoded = 0;
  std::uint32_t refused = 0;  ///< bricks for which there was no room
};

class Cache {
 public:
  virtual ~Cache() = default;
  /// Adds what the marcher's kernel needs to `source`, which holds the frame's alone; includes
  /// the decoder if it is called.
  virtual void extend_kernel(KernelSource& source) const = 0;
  /// Addresses and sizes of the mode's buffers.
  virtual void describe(FrameConstants& frame) const = 0;
  /// Forgets what depends on the scene; records on `commands`. `everything`: forgets all cached
  /// labels too.
  virtual void clear(Commands& commands, bool everything) = 0;
  /// Records the passes before rendering; `frame` is FrameConstants::frame.
  virtual void record(Commands&, std::uint32_t /*frame*/) {}
  /// Reads what the frame's passes report, after the submission.
  virtual CacheReport report() { return {}; }
  virtual std::vector<MemoryUse> memory() const { return {}; }
};

struct CacheTraits {
  std::string_view id;
  std::string_view summary;
  bool sized;  ///< the cache size matters
  bool
      placeholders;  ///< a label that is not there yet is stood in for; pictures are exact only later
  bool labels = true;    ///< serves label volumes
  bool scalars = false;  ///< serves scalar volumes, by gpu/scalars/renderer.hpp, which knows how
  /// Why this mode cannot serve an encoding on a device; empty if it can.
  std::string (*refuses)(const codecs::GpuEncoding&, const DeviceLimits&);
  /// Of modes that serve labels; else nullptr.
  volumes::Expected<std::unique_ptr<Cache>> (*make)(const CacheSetting&);
};

std::span<const CacheTraits> all_caches();
const CacheTraits* find_cache(std::string_view id);

inline constexpr std::uint64_t kLeastCacheBytes = std::uint64_t{1} << 20;

}  // namespace cvr::gpu
