// The stage render: images of the volume from its encoded form, on a Vulkan device
// (render.cpp).
#include <fmt/format.h>

#include <algorithm>

#include "experiments/stages/frame_times.hpp"
#include "experiments/stages/render_run.hpp"
#include "experiments/stages/stage_kind.hpp"
#include "gpu/caches/cache.hpp"

namespace cvr::experiments {

namespace {

constexpr double kStartSeconds = 4;
constexpr double kPixelsPerSecond = 2e6;
constexpr double kCheckFrames = 20;
constexpr double kMiB = 1 << 20;
constexpr double kDriver = 256 * kMiB;
constexpr double kPixel = 300;  ///< bytes, of images and suspended rays
/// What `raw`, with which images are compared, takes at most where device memory is the host's: the
/// largest allocation of lavapipe.
constexpr double kLargestRaw = 2048 * kMiB;

std::string refusal_of(const RenderChoice& choice, bool labels) {
  const gpu::CacheTraits& access = *gpu::find_cache(choice.access);
  if (labels) return access.labels ? "" : fmt::format("{} serves scalar volumes alone", access.id);
  if (!access.scalars) return fmt::format("{} serves label volumes alone", access.id);
  if (choice.shading != gpu::Shading::kLocal)
    return "scalar volumes are shaded by their gradients alone: local";
  return "";
}

class RenderStage final : public StageKind {
 public:
  const StageTraits& traits() const override {
    static constexpr StageTraits kTraits{
        .id = "render",
        .sentence = "Frames of a camera path from the encoded form on a Vulkan device",
        .renders = true};
    return kTraits;
  }
  std::string unsupported_reason(const Cell& cell, const codecs::Traits& codec,
                                 const volumes::VolumeInfo& info) const override {
    const bool labels = info.kind == volumes::VolumeKind::kLabels;
    if (!(labels ? codec.gpu_decodable : codec.gpu_scalars)) return "no decoder for the GPU";
    return refusal_of(*cell.render, labels);
  }
  double expected_seconds(const Cell& cell, const volumes::VolumeInfo&,
                          double rounds) const override {
    const RenderChoice& render = *cell.render;
    const auto pixels = static_cast<double>(std::uint64_t{render.width} * render.height);
    const double frames =
        kCheckFrames + (rounds + 1) * (render.frames * render.ao_samples + render.warm_frames);
    return kStartSeconds + frames * pixels / kPixelsPerSecond;
  }
  /// The volume in memory, the coarser levels of the reference, all levels for `raw`; the cache of
  /// the timed and of the counting renderer. What is encoded is small beside them. A row's peak is
  /// of the rounds alone, after the reference has gone.
  double expected_memory(const Cell& cell, const volumes::VolumeInfo& info,
                         const MemoryChoices&) const override {
    const RenderChoice& render = *cell.render;
    const auto pixels = static_cast<double>(std::uint64_t{render.width} * render.height);
    const auto bytes = static_cast<double>(info.bytes());
    return bytes + bytes / 7 + std::min(bytes / 7 * 8, kLargestRaw) +
           static_cast<double>(render.cache_mib) * 2 * kMiB + kPixel * pixels + kDriver;
  }
  bool memory_scales() const override { return false; }
  bool limits_address_space() const override { return false; }  // drivers reserve as they like
  bool takes_turns_on_a_core(const Cell&) const override { return false; }

  std::unique_ptr<StageRun> make_run(const StageInput& input) const override {
    return make_render_run(input);
  }

  void add_times(const Measured& measured, const volumes::VolumeInfo&,
                 Parts& parts) const override {
    const Measured::Series& series = measured.series.front();
    parts.time->seconds = describe_samples(series.wall_seconds);
    parts.time->cpu_seconds = describe_samples(series.cpu_seconds);
    parts.frames = describe_frames(measured);
    Parts::Held held = parts.held.value_or(Parts::Held());
    if (add_held_frames(measured, held)) parts.held = std::move(held);
  }
  std::string headline(const Parts& parts) const override {
    return fmt::format("{:.4g} ms per frame", parts.frames.value().mean_ms.value());
  }
};

}  // namespace

const StageKind& render_stage() {
  static const RenderStage kStage;
  return kStage;
}

}  // namespace cvr::experiments
