// What drawing labels and drawing scalars do not have in common: how an encoding becomes a
// renderer, what its images must be, and what is measured besides.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "codecs/container.hpp"
#include "experiments/stages/render_parts.hpp"
#include "experiments/stages/stage.hpp"
#include "gpu/frame_renderer.hpp"

namespace cvr::experiments {

/// What a cell of the render stage draws, and on what; outlives its users.
struct RenderSetting {
  const WorkerSpec& spec;
  const RenderChoice& choice;
  const gpu::Scene& scene;
  const volumes::VolumeSource& truth;
  gpu::Device& device;

  gpu::RenderOptions options(bool instrumented) const;
  Shot fixed_shot() const { return {scene.path.part_of(scene.held), 1, scene.lod_bias}; }
  gpu::Camera fixed_camera() const { return scene.path.at(fixed_shot().part); }
  /// Draws a shot from an empty cache. Throws StageFailure where the cache is too small for it.
  gpu::Settled settle(gpu::FrameRenderer& renderer, const Shot& shot) const;
  /// Draws the fixed view until the cache, if the renderer keeps one, has what it can hold of it.
  void fill_cache(gpu::FrameRenderer& renderer) const;
  /// Seconds of the passes; nothing where there are none.
  std::optional<double> show_scene(gpu::FrameRenderer& renderer) const;
};

class RenderSubject {
 public:
  virtual ~RenderSubject() = default;
  /// Checks the encoding as far as it is not done by images, and adds what it finds.
  virtual void check_encoding(std::span<const std::byte> file, Parts& parts) = 0;
  /// Adds what of the encoding is drawn.
  virtual void describe(Parts&) const {}
  /// For timed frames.
  virtual std::unique_ptr<gpu::FrameRenderer> make_renderer() = 0;
  /// Checks images of the scene that the renderer shows at kCheckedParts, and adds
  /// "verification". Throws StageFailure.
  virtual void check_images(gpu::FrameRenderer& renderer, Parts& parts) = 0;
  /// What an image of the original is.
  virtual gpu::Image reference(const Shot& shot) = 0;
  /// Adds what is measured of images and work besides frame times.
  virtual void measure(gpu::FrameRenderer&, Parts&) {}
};

/// `setting` and `decoder` outlive the results.
std::unique_ptr<RenderSubject> make_label_subject(const RenderSetting& setting,
                                                  const codecs::Decoder& decoder);
std::unique_ptr<RenderSubject> make_scalar_subject(const RenderSetting& setting,
                                                   const codecs::Decoder& decoder);

}  // namespace cvr::experiments
