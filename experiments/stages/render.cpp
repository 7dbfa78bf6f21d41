// Images of the volume from its encoded form, on a Vulkan device: checked first (render_labels.cpp,
// render_scalars.cpp), then timed.
//
// A round is the camera path once, from an empty cache: for each camera ao_samples frames. Then,
// where warm frames are asked for, the camera stands still at the scene's fixed view: where the
// renderer keeps voxels from frame to frame, the image is settled and kFillingFrames more frames
// let the cache take in what was pushed out by others on the way; and the frames of the fixed view
// are timed. Each starts anew with the first sample, so all trace the same rays. Times are those of
// the device's timestamps, pass by pass.
#include <fmt/format.h>

#include "codecs/container.hpp"
#include "experiments/stages/encoded_volume.hpp"
#include "experiments/stages/render_parts.hpp"
#include "experiments/stages/render_run.hpp"
#include "experiments/stages/render_subject.hpp"

namespace cvr::experiments {

namespace {

constexpr std::uint32_t kFillingFrames = 2;

void require_scene(const gpu::Scene& scene, volumes::VolumeKind kind) {
  if (kind == volumes::VolumeKind::kLabels && scene.materials.empty())
    throw StageFailure(kUnsupported,
                       fmt::format("scene {} has no materials, which labels need", scene.name));
  if (kind == volumes::VolumeKind::kScalars && scene.transfer.empty())
    throw StageFailure(
        kUnsupported,
        fmt::format("scene {} has no transfer function, which scalars need", scene.name));
}

class RenderRun final : public StageRun {
 public:
  explicit RenderRun(const StageInput& input)
      : spec_(input.spec),
        truth_(input.truth),
        source_(input.source),
        hooks_(input.hooks),
        choice_(*spec_.render),
        scene_(scene_of(choice_)) {}

  Parts prepare() override {
    require_scene(scene_, truth_.info().kind);
    gpu::DeviceOptions options{.choice = choice_.device};
    hooks_.change_device(options);
    device_ = std::make_unique<gpu::Device>(options);
    const RenderSetting setting = this->setting();
    const codecs::Buffer bytes = obtain_encoded(spec_, source_);
    const auto file = checked(codecs::open_file(bytes.bytes()));
    const auto decoder = checked(codecs::open_decoder(file));
    const auto subject = truth_.info().kind == volumes::VolumeKind::kLabels
                             ? make_label_subject(setting, *decoder)
                             : make_scalar_subject(setting, *decoder);
    renderer_ = subject->make_renderer();
    Parts parts;
    if (spec_.checked) {
      setting.show_scene(*renderer_);
      return parts;
    }
    parts.device = describe_device(*device_);
    subject->check_encoding(bytes.bytes(), parts);
    parts.size = describe_size(file, bytes.size(), spec_.bytes_per_voxel);
    subject->describe(parts);
    Named<double>& start = parts.start.emplace();
    for (const auto& [name, seconds] : renderer_->start_parts()) start[name + "_s"] = seconds;
    if (const auto seconds = setting.show_scene(*renderer_)) start["scene_s"] = *seconds;
    subject->check_images(*renderer_, parts);
    if (choice_.keep_images) {
      setting.settle(*renderer_, setting.fixed_shot());
      parts.pictures =
          keep_pictures(spec_, subject->reference(setting.fixed_shot()), renderer_->read_image());
    }
    subject->measure(*renderer_, parts);
    parts.memory = describe_memory(renderer_->memory());
    return parts;
  }

  std::vector<Sample> round() override {
    const RenderSetting setting = this->setting();
    std::vector<Sample> samples(1);
    const Stopwatch watch;
    renderer_->clear_cache();
    double seconds = 0;
    for (std::uint32_t frame = 0; frame < scene_.frames; ++frame) {
      for (std::uint32_t sample = 0; sample < choice_.ao_samples; ++sample) {
        const gpu::FrameResult result = renderer_->render(scene_.camera(frame), sample == 0);
        add_frame(result, "frame", "pass/", samples);
        seconds += result.gpu_seconds;
      }
    }
    samples.front() = watch.lap("path", std::uint64_t{scene_.frames} * choice_.ao_samples);
    samples.front().wall_seconds = seconds;
    if (choice_.warm_frames > 0) setting.fill_cache(*renderer_);
    for (std::uint32_t frame = 0; frame < choice_.warm_frames; ++frame)
      add_frame(renderer_->render(setting.fixed_camera()), "held", "held-pass/", samples);
    return samples;
  }

 private:
  RenderSetting setting() const { return {spec_, choice_, scene_, truth_, *device_}; }

  WorkerSpec spec_;
  const volumes::VolumeSource& truth_;
  const volumes::VolumeSource& source_;
  StageHooks& hooks_;
  const RenderChoice& choice_;
  gpu::Scene scene_;
  std::unique_ptr<gpu::Device> device_;
  std::unique_ptr<gpu::FrameRenderer> renderer_;
};

}  // namespace

gpu::RenderOptions RenderSetting::options(bool instrumented) const {
  gpu::RenderOptions options;
  options.access = choice.access;
  if (choice.cache_mib > 0) options.cache_bytes = choice.cache_mib << 20;
  options.shading = choice.shading;
  options.width = choice.width;
  options.height = choice.height;
  options.instrumented = instrumented;
  return options;
}

gpu::Settled RenderSetting::settle(gpu::FrameRenderer& renderer, const Shot& shot) const {
  renderer.clear_cache();
  const gpu::Settled settled = renderer.settle(scene.path.at(shot.part), shot.samples);
  if (!settled.complete) {
    throw StageFailure(
        kFailed, fmt::format("the cache cannot hold what one view needs: {} pixels incomplete",
                             settled.incomplete));
  }
  return settled;
}

void RenderSetting::fill_cache(gpu::FrameRenderer& renderer) const {
  if (!renderer.keeps_voxels()) return;
  renderer.settle(fixed_camera());
  for (std::uint32_t frame = 0; frame < kFillingFrames; ++frame) renderer.render(fixed_camera());
}

std::optional<double> RenderSetting::show_scene(gpu::FrameRenderer& renderer) const {
  const std::vector<gpu::PassTime> passes = checked(renderer.set_scene(scene));
  if (passes.empty()) return std::nullopt;
  double seconds = 0;
  for (const gpu::PassTime& pass : passes) seconds += pass.seconds;
  return seconds;
}

std::unique_ptr<StageRun> make_render_run(const StageInput& input) {
  return std::make_unique<RenderRun>(input);
}

}  // namespace cvr::experiments
