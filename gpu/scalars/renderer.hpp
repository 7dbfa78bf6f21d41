// The renderer of scalar volumes (transform vector quantisation paper, deferred filtering): slices
// along the axis nearest to the view are decoded into a ring, from which values are interpolated
// and gradients taken; or, for comparison, every sample decodes the voxels that it needs. The
// paper's ring has the four slices that one slab needs; a larger one draws several slabs at a time.
// Both draw the same picture (gpu/IMAGE.md, Scalars).
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
  std::vector<PassTime>
      passes;  ///< the whole frame is one pass, "render"; slices are decoded and drawn in turn
  double gpu_seconds = 0;
  double host_seconds = 0;
  std::uint64_t decoded = 0;  ///< voxels decoded into slices
};

struct ScalarRenderOptions {
  std::string access =
      "slices";  ///< "none": each sample decodes what it needs; "slices": deferred filtering
  std::uint64_t cache_bytes =
      0;  ///< what the ring may take; it has four slices at least, at most those of the volume
  std::uint32_t width = 640, height = 360;
};

class ScalarRenderer {
 public:
  /// `samples` and its buffers outlive the call only. kUnsupported for other access modes and where
  /// a device limit stands against it, kBadArgument for a picture without or with too many pixels.
  static volumes::Expected<std::unique_ptr<ScalarRenderer>> make(
      Device& device, const codecs::GpuSamples& samples, const volumes::VolumeInfo& info,
      const ScalarRenderOptions& options);
  ~ScalarRenderer();

  /// `range`: what the ends of the transfer function mean.
  void set_scene(const Scene& scene, const ValueRange& range);
  /// Draws the slabs [first, last) of the view's order alone, to time a part of a large volume; all
  /// by default.
  ScalarFrameResult render(const Camera& camera, std::uint32_t first = 0,
                           std::uint32_t last = UINT32_MAX);
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
