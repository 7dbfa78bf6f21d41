// The contracts of access modes: how the renderers get at voxels. One file and one shader source per
// mode, one line in caches.cpp.
//
// A mode declares what it needs of the codec and the device, owns its device memory, adds its
// source to the renderer's kernel and records its passes. It knows no codec by name. A mode serves
// labels by a Cache, scalars by a SampleAccess, or both.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codecs/gpu_encoding.hpp"
#include "codecs/gpu_samples.hpp"
#include "gpu/allocations.hpp"
#include "gpu/frame.hpp"
#include "gpu/frame_renderer.hpp"
#include "gpu/scalars/frame.hpp"
#include "gpu/vulkan/commands.hpp"
#include "volumes/error.hpp"
#include "volumes/volume.hpp"

namespace cvr::gpu {

/// What a mode of labels is built on; outlives it.
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

/// What a mode of scalars is built on; outlives it.
struct SampleSetting {
  Device& device;
  Commands& commands;
  Allocations& allocations;
  volumes::VolumeInfo info;
  std::uint64_t cache_bytes;  ///< what the mode may take
  KernelSource decoder;       ///< the frame and the codec's decoder, with their definitions
};

/// How the compositing of scalars gets at samples: slab m of a frame lies between slices m and m +
/// 1, counted in the order of the view, and needs slices m - 1 to m + 2.
class SampleAccess {
 public:
  virtual ~SampleAccess() = default;
  /// Adds what the compositing kernel needs to `source`, which holds the decoder.
  virtual void extend_kernel(KernelSource& source) const = 0;
  /// Addresses and sizes of the mode's buffers.
  virtual void describe(ScalarFrame& frame) const = 0;
  /// Slabs, from 1, that may be composited after one record().
  virtual std::uint32_t slabs_at_a_time(const ScalarFrame& frame) const = 0;
  /// Records what makes the slices [first, last) available; returns the voxels that it decodes.
  virtual std::uint64_t record(Commands& commands, const ScalarFrame& frame, std::uint32_t first,
                               std::uint32_t last) = 0;
};

struct CacheTraits {
  std::string_view id;
  std::string_view summary;
  bool sized;  ///< the cache size matters
  bool
      placeholders;  ///< a label that is not there yet is stood in for; images are exact only later
  bool exact = true;     ///< draws the image of gpu/IMAGE.md; else its wrong pixels are counted
  bool labels = true;    ///< serves label volumes: has `make`
  bool scalars = false;  ///< serves scalar volumes: has `make_samples`
  /// Why this mode cannot serve an encoding of labels on a device; empty if it can.
  std::string (*refuses)(const codecs::GpuEncoding&, const DeviceLimits&);
  volumes::Expected<std::unique_ptr<Cache>> (*make)(const CacheSetting&) = nullptr;
  volumes::Expected<std::unique_ptr<SampleAccess>> (*make_samples)(const SampleSetting&) = nullptr;
};

std::span<const CacheTraits> all_caches();
const CacheTraits* find_cache(std::string_view id);

/// Of labels.
inline constexpr std::uint64_t kLeastCacheBytes = std::uint64_t{1} << 20;

}  // namespace cvr::gpu
