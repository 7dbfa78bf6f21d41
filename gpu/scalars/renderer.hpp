// The renderer of scalar volumes (transform vector quantisation paper): sample planes between slices
// are composited front to back. An access mode says where samples come from: from a ring of decoded
// slices (deferred filtering), or, for comparison, each from the voxels that it needs, decoded
// there. All draw the same image (gpu/IMAGE.md, Scalars).
#pragma once

#include <memory>

#include "codecs/gpu_samples.hpp"
#include "gpu/frame_renderer.hpp"
#include "gpu/scalars/transfer.hpp"
#include "volumes/volume.hpp"

namespace cvr::gpu {

class ScalarRenderer final : public FrameRenderer {
 public:
  /// `samples` and its buffers outlive the call only. `range`: what the ends of transfer functions
  /// mean. kUnsupported where mode, codec or device do not go together. Of the options, shading
  /// does not count (IMAGE.md), and there is one renderer, instrumented or not.
  static volumes::Expected<std::unique_ptr<ScalarRenderer>> make(Device& device,
                                                                 const codecs::GpuSamples& samples,
                                                                 const volumes::VolumeInfo& info,
                                                                 const ValueRange& range,
                                                                 const RenderOptions& options);
  ~ScalarRenderer() override;

  volumes::Expected<std::vector<PassTime>> set_scene(const Scene& scene) override;
  bool keeps_voxels() const override { return false; }
  void clear_cache() override {}
  /// The whole frame is one pass, "render"; slices are decoded and drawn in turn.
  FrameResult render(const Camera& camera, bool restart = true) override;
  /// Draws the slabs [first, last) of the view's order alone, to time a part of a large volume.
  FrameResult render_slabs(const Camera& camera, std::uint32_t first, std::uint32_t last);
  /// Every frame is exact.
  Settled settle(const Camera& camera, std::uint32_t samples = 1) override;
  /// Colours; no labels, all pixels complete.
  Image read_image() const override;
  /// cells_decoded: voxels decoded into slices.
  Counters read_counters() const override;
  void clear_counters() override;
  std::vector<MemoryUse> memory() const override;
  std::vector<std::pair<std::string, double>> start_parts() const override;

 private:
  struct Impl;
  explicit ScalarRenderer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cvr::gpu
