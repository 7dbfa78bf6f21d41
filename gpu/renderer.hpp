// The renderer of label volumes: rays through bricks, cell by cell of each brick's level of detail.
#pragma once

#include <memory>

#include "codecs/gpu_encoding.hpp"
#include "gpu/frame_renderer.hpp"
#include "volumes/volume.hpp"

namespace cvr::gpu {

class Renderer final : public FrameRenderer {
 public:
  /// `encoding` and its buffers outlive the call only. kUnsupported with the reason where mode,
  /// codec, volume or device do not go together.
  static volumes::Expected<std::unique_ptr<Renderer>> make(Device& device,
                                                           const codecs::GpuEncoding& encoding,
                                                           const volumes::VolumeInfo& info,
                                                           const RenderOptions& options);
  ~Renderer() override;

  /// Passes: materials, and bricks without a visible label.
  volumes::Expected<std::vector<PassTime>> set_scene(const Scene& scene) override;
  bool keeps_voxels() const override;
  void clear_cache() override;
  FrameResult render(const Camera& camera, bool restart = true) override;
  Settled settle(const Camera& camera, std::uint32_t samples = 1) override;
  Image read_image() const override;
  /// Of an instrumented renderer; else zeros.
  Counters read_counters() const override;
  void clear_counters() override;
  std::vector<MemoryUse> memory() const override;
  /// Of make() and the first set_scene().
  std::vector<std::pair<std::string, double>> start_parts() const override;

 private:
  struct Impl;
  explicit Renderer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cvr::gpu
