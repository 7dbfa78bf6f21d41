// The renderer of scalar volumes (transform vector quantisation paper, deferred filtering): slices along the axis nearest to the view are
// decoded into a ring of four, from which values are interpolated and gradients taken; or, for comparison, every sample decodes the
// voxels that it needs. Both draw the same picture (gpu/IMAGE.md, Scalars).
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "codecs/gpu_samples.hpp"
#include "gpu/caches/cache.hpp"
#include "gpu/image.hpp"
#include "gpu/scalars/transfer.hpp"
#include "gpu/vulkan/commands.hpp"

namespace cvr::gpu {

struct ScalarFrameResult {
  std::vector<PassTime> passes;  ///< the whole frame is one pass, "render"; slices are decoded and drawn in turn
  double gpu_seconds = 0;
  double host_seconds = 0;
  std::uint64_t decoded = 0;     ///< voxels decoded into slices
};

class ScalarRenderer {
 public:
  /// `samples` and its buffers outlive the call only. `access`: "none" (each sample decodes what it needs) or "slices" (deferred filtering).
  /// kUnsupported for other access modes and where a device limit stands against it, kBadArgument for a picture without or with too many pixels.
  static volumes::Expected<std::unique_ptr<ScalarRenderer>> make(Device& device, const codecs::GpuSamples& samples,
                                                                 const volumes::VolumeInfo& info, std::string_view access,
                                                                 std::uint32_t width, std::uint32_t height);
  ~ScalarRenderer();

  /// `range`: what the ends of the transfer function mean.
  void set_scene(const Scene& scene, const ValueRange& range);
  /// Draws the slabs [first, last) of the view's order alone, to time a part of a large volume; all by default.
  ScalarFrameResult render(const Camera& camera, std::uint32_t first = 0, std::uint32_t last = UINT32_MAX);
  /// Colours; no labels, all pixels complete.
  Image read_image() const;
  std::vector<MemoryUse> memory() const;
  std::vector<std::pair<std::string, double>> start_parts() const;

 private:
  struct Impl;
  explicit ScalarRenderer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cvr::gpu
