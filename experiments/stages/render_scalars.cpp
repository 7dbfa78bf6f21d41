// Pictures of a scalar volume from its encoded form, on a Vulkan device.
//
// Checked first, at three cameras of the path: the picture must be that of the reference in double
// precision of the decoded volume, to kLeastPsnr. The error that the codec makes in pictures is
// measured apart, against the reference of the original ("picture_error").
//
// A round is the camera path once, then the held view. There is no cache that could be filled: each
// frame does the whole work.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "codecs/container.hpp"
#include "experiments/stages/encoded_volume.hpp"
#include "experiments/stages/render_parts.hpp"
#include "experiments/stages/render_runs.hpp"
#include "gpu/scalars/reference.hpp"
#include "gpu/scalars/renderer.hpp"

namespace cvr::experiments {

namespace {

constexpr double kLeastPsnr =
    60;  ///< dB, of single against double precision; a wrong voxel value shows long before

unsigned cores() { return std::max(1u, std::thread::hardware_concurrency()); }

/// The mean of several pictures' differences.
struct PictureErrors {
  double mse = 0, largest = 0, ssim = 0;
  std::uint64_t pixels = 0;
  unsigned pictures = 0;

  void add(const gpu::ImageDifference& difference) {
    mse += difference.mse;
    ssim += difference.ssim;
    largest = std::max(largest, difference.largest);
    pixels += difference.pixels;
    ++pictures;
  }
  Row psnr_db() const { return mse > 0 ? Row(-10 * std::log10(mse / pictures)) : Row(nullptr); }
};

class ScalarRenderRun final : public StageRun {
 public:
  ScalarRenderRun(const WorkerSpec& spec, const volumes::VolumeSource& truth)
      : spec_(spec), truth_(truth), choice_(*spec_.render), scene_(scene_of(choice_)) {}

  Row prepare() override {
    if (scene_.transfer.empty())
      throw StageFailure(
          kUnsupported,
          fmt::format("scene {} has no transfer function, which scalars need", scene_.name));
    device_ = std::make_unique<gpu::Device>(gpu::DeviceOptions{.choice = choice_.device});
    const codecs::Buffer bytes = obtain_encoded(spec_, truth_);
    const auto file = checked(codecs::open_file(bytes.bytes()));
    const auto decoder = checked(codecs::open_decoder(file));
    const codecs::ProgressiveAccess* progressive = decoder->progressive_access();
    if (choice_.step && (progressive == nullptr || *choice_.step >= progressive->steps())) {
      throw StageFailure(kUnsupported,
                         fmt::format("step {}: the encoding has {}", *choice_.step,
                                     progressive == nullptr ? 1 : progressive->steps()));
    }
    const unsigned step = choice_.step             ? *choice_.step
                          : progressive == nullptr ? 0
                                                   : progressive->steps() - 1;
    renderer_ = checked(gpu::ScalarRenderer::make(*device_, checked(decoder->gpu_samples(step)),
                                                  truth_.info(),
                                                  {.access = choice_.access,
                                                   .cache_bytes = choice_.cache_mib << 20,
                                                   .width = choice_.width,
                                                   .height = choice_.height}));
    const volumes::Volume original = volumes::read_all(truth_);
    const gpu::ValueRange range = gpu::value_range(original);
    renderer_->set_scene(scene_, range);

    volumes::VolumeSink sink(truth_.info());
    checked(progressive == nullptr ? decoder->decode(0, cores(), sink)
                                   : progressive->decode_step(step, cores(), sink));
    Row parts;
    parts["device"] = describe_device(*device_);
    parts["size"] = describe_size(file, bytes.size(), spec_.bytes_per_voxel);
    if (progressive != nullptr) {
      parts["step"] = {{"name", progressive->step_name(step)},
                       {"bytes", progressive->step_bytes(step)}};
    }
    for (const auto& [name, seconds] : renderer_->start_parts())
      parts["start"][name + "_s"] = seconds;
    check_pictures(original, sink.take(), range, parts);
    if (choice_.keep_pictures) {
      renderer_->render(held_camera());
      parts["pictures"] =
          keep_pictures(spec_, gpu::render_scalars(original, scene_, range, held_camera(), cores()),
                        renderer_->read_image());
    }
    parts["memory"] = describe_memory(renderer_->memory());
    return parts;
  }

  std::vector<Sample> round() override {
    std::vector<Sample> samples(1);
    const Stopwatch watch;
    double seconds = 0;
    for (std::uint32_t frame = 0; frame < scene_.frames; ++frame) {
      const auto result = renderer_->render(scene_.camera(frame));
      add_frame(result, 0, "frame", "pass/", samples);
      seconds += result.gpu_seconds;
    }
    samples.front() = watch.lap("path", scene_.frames);
    samples.front().wall_seconds = seconds;
    for (std::uint32_t frame = 0; frame < choice_.held_frames; ++frame)
      add_frame(renderer_->render(held_camera()), 0, "held", "held-pass/", samples);
    return samples;
  }

 private:
  gpu::Camera held_camera() const { return scene_.path.at(scene_.path.part_of(scene_.held)); }

  void check_pictures(const volumes::Volume& original, const volumes::Volume& decoded,
                      const gpu::ValueRange& range, Row& parts) {
    PictureErrors renderer, codec;
    std::uint64_t voxels = 0;
    for (const double part : kCheckedParts) {
      const gpu::Camera camera = scene_.path.at(part);
      voxels += renderer_->render(camera).decoded;
      const gpu::Image image = renderer_->read_image();
      const gpu::ImageDifference difference =
          gpu::compare(gpu::render_scalars(decoded, scene_, range, camera, cores()), image);
      if (difference.mse > 0 && difference.psnr < kLeastPsnr) {
        throw StageFailure(kFailed, fmt::format("at part {} of the path the picture is {:.1f} dB "
                                                "from that of the reference, {:.0f} "
                                                "at least were expected",
                                                part, difference.psnr, kLeastPsnr));
      }
      renderer.add(difference);
      codec.add(gpu::compare(gpu::render_scalars(original, scene_, range, camera, cores()), image));
    }
    parts["verification"] = {{"pixels_compared", renderer.pixels},
                             {"psnr_db", renderer.psnr_db()},
                             {"largest_difference", renderer.largest}};
    parts["picture_error"] = {{"psnr_db", codec.psnr_db()},
                              {"ssim", codec.ssim / codec.pictures},
                              {"largest", codec.largest},
                              {"pixels", codec.pixels}};
    parts["counters"]["cells_decoded"] = voxels;
  }

  WorkerSpec spec_;
  const volumes::VolumeSource& truth_;
  const RenderChoice& choice_;
  gpu::Scene scene_;
  std::unique_ptr<gpu::Device> device_;
  std::unique_ptr<gpu::ScalarRenderer> renderer_;
};

}  // namespace

std::unique_ptr<StageRun> make_scalar_render_run(const WorkerSpec& spec,
                                                 const volumes::VolumeSource& truth) {
  if (!spec.render) throw StageFailure(kFailed, "a render stage without its choices");
  return std::make_unique<ScalarRenderRun>(spec, truth);
}

}  // namespace cvr::experiments
