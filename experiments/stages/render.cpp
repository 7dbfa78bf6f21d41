// Pictures of the volume from its encoded form, on a Vulkan device.
//
// Checked first, at three cameras of the path: once settled, labels and colours must be exactly
// those of the codec `raw` without a cache on this device, and the labels those of the reference in
// double precision but for near-ties (gpu/IMAGE.md), of which there may be one, and one more in
// every 10^5 pixels. Colours may differ from the reference's in one pixel of 10^4. What is counted
// (cells read and decoded, words touched) comes from a second renderer, whose kernels count; the
// timed one does not.
//
// A round is the camera path once, from an empty cache: for each camera ao_samples frames. Then,
// where held_frames are asked for, the camera stands still at the scene's held view: the picture is
// settled, kFillingFrames more frames let the cache take in what was pushed out by others on the
// way, and the held frames are timed. Each starts anew with the first sample, so all trace the same
// rays. Times are those of the device's timestamps, pass by pass.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <thread>

#include "codecs/container.hpp"
#include "experiments/stages/encoded_volume.hpp"
#include "experiments/stages/render_parts.hpp"
#include "experiments/stages/render_runs.hpp"
#include "experiments/stages/render_truth.hpp"

namespace cvr::experiments {

namespace {

constexpr double kJumpFrom = 0.0, kJumpTo = 0.5;
constexpr double kErrorPart =
    0.37;  ///< where pictures with fewer levels or samples are compared with the best
constexpr std::uint32_t kBestSamples = 256;  ///< of the best picture with random rays
constexpr std::uint32_t kCheckedSamples =
    4;  ///< at most; more would make the check longer than the measurement
constexpr double kNearTiesAllowed = 1e-5;  ///< of the pixels
constexpr double kOtherColoursAllowed =
    1e-4;  ///< of the pixels: secondary rays have near-ties that nobody looks for
constexpr std::uint32_t kFillingFrames = 2;

unsigned cores() { return std::max(1u, std::thread::hardware_concurrency()); }

/// One pixel may always differ: of a small picture it is more than its share.
std::uint64_t allowed(double share, std::uint64_t pixels) {
  return 1 + static_cast<std::uint64_t>(share * static_cast<double>(pixels));
}

class RenderRun final : public StageRun {
 public:
  RenderRun(const WorkerSpec& spec, const volumes::VolumeSource& truth)
      : spec_(spec), truth_(truth), choice_(*spec_.render), scene_(scene_of(choice_)) {}

  Row prepare() override {
    if (scene_.materials.empty())
      throw StageFailure(kUnsupported,
                         fmt::format("scene {} has no materials, which labels need", scene_.name));
    device_ = std::make_unique<gpu::Device>(gpu::DeviceOptions{.choice = choice_.device});
    const AlteredSource altered(truth_);
    const volumes::VolumeSource& source =
        spec_.fault == "mismatch" ? static_cast<const volumes::VolumeSource&>(altered) : truth_;
    const codecs::Buffer bytes = obtain_encoded(spec_, source);
    const auto file = checked(codecs::open_file(bytes.bytes()));
    const auto decoder = checked(codecs::open_decoder(file));
    const auto encoding = checked(decoder->gpu_encoding(choice_.brick, cores()));
    renderer_ = make_renderer(encoding, false);
    Row parts;
    parts["device"] = describe_device(*device_);
    verify_once(spec_, bytes.bytes(), truth_, parts);
    parts["size"] = describe_size(file, bytes.size(), spec_.bytes_per_voxel);
    Row& start = parts["start"];
    for (const auto& [name, seconds] : renderer_->start_parts()) start[name + "_s"] = seconds;
    start["scene_s"] = show_scene(*renderer_);
    RenderTruth truth(spec_, truth_, scene_, *device_);
    check_pictures(truth, parts);
    if (choice_.keep_pictures) {
      settle(held_shot());
      parts["pictures"] =
          keep_pictures(spec_, truth.reference(held_shot()), renderer_->read_image());
    }
    measure_jump(truth, parts);
    measure_error(truth, parts);
    count_work(truth, encoding, parts);
    parts["memory"] = describe_memory(renderer_->memory());
    return parts;
  }

  std::vector<Sample> round() override {
    std::vector<Sample> samples(1);
    const Stopwatch watch;
    renderer_->clear_cache();
    if (spec_.fault == "device-lost") device_->lose_on_purpose();
    double seconds = 0;
    for (std::uint32_t frame = 0; frame < scene_.frames; ++frame) {
      for (std::uint32_t sample = 0; sample < choice_.ao_samples; ++sample) {
        const gpu::FrameResult result = renderer_->render(scene_.camera(frame), sample == 0);
        add_frame(result, result.incomplete, "frame", "pass/", samples);
        seconds += result.gpu_seconds;
      }
    }
    samples.front() = watch.lap("path", std::uint64_t{scene_.frames} * choice_.ao_samples);
    samples.front().wall_seconds = seconds;
    if (choice_.held_frames > 0) fill_cache(*renderer_);
    for (std::uint32_t frame = 0; frame < choice_.held_frames; ++frame) {
      const gpu::FrameResult result = renderer_->render(held_camera());
      add_frame(result, result.incomplete, "held", "held-pass/", samples);
    }
    return samples;
  }

 private:
  bool has_cache() const { return gpu::find_cache(choice_.access)->sized; }

  Shot held_shot() const { return {scene_.path.part_of(scene_.held), 1, scene_.lod_bias}; }
  gpu::Camera held_camera() const { return scene_.path.at(held_shot().part); }

  /// Draws the held view until the cache, if there is one, has what it can hold of it.
  void fill_cache(gpu::Renderer& renderer) const {
    if (!has_cache()) return;
    renderer.settle(held_camera());
    for (std::uint32_t frame = 0; frame < kFillingFrames; ++frame) renderer.render(held_camera());
  }

  std::unique_ptr<gpu::Renderer> make_renderer(const codecs::GpuEncoding& encoding,
                                               bool instrumented) {
    gpu::RenderOptions options;
    options.access = choice_.access;
    if (choice_.cache_mib > 0) options.cache_bytes = choice_.cache_mib << 20;
    options.shading = choice_.shading;
    options.width = choice_.width;
    options.height = choice_.height;
    options.instrumented = instrumented;
    return checked(gpu::Renderer::make(*device_, encoding, truth_.info(), options));
  }

  /// Seconds of the passes.
  double show_scene(gpu::Renderer& renderer) const {
    double seconds = 0;
    for (const gpu::PassTime& pass : checked(renderer.set_scene(scene_))) seconds += pass.seconds;
    return seconds;
  }

  gpu::Settled settle(const Shot& shot) {
    renderer_->clear_cache();
    const gpu::Settled settled = renderer_->settle(scene_.path.at(shot.part), shot.samples);
    if (!settled.complete) {
      throw StageFailure(
          kFailed, fmt::format("the cache cannot hold what one view needs: {} pixels incomplete",
                               settled.incomplete));
    }
    return settled;
  }

  void check_pictures(RenderTruth& truth, Row& parts) {
    const std::uint32_t samples = std::min(choice_.ao_samples, kCheckedSamples);
    std::uint64_t frames = 0;
    PictureErrors errors;
    for (const double part : kCheckedParts) {
      const Shot shot{part, samples, scene_.lod_bias};
      frames = std::max<std::uint64_t>(frames, settle(shot).frames);
      compare_picture(truth, shot, errors);
    }
    if (choice_.held_frames > 0) check_held(truth, errors, parts);
    const auto& [pixels, differing, near_ties, colours, largest, mse] = errors;
    if (differing > near_ties) {
      throw StageFailure(
          kFailed,
          fmt::format(
              "{} of {} pixels have labels other than those of the reference, {} of them near-ties",
              differing, pixels, near_ties));
    }
    if (near_ties > allowed(kNearTiesAllowed, pixels)) {
      throw StageFailure(kFailed,
                         fmt::format("{} of {} pixels are near-ties, more than 1 and one in 10^5",
                                     near_ties, pixels));
    }
    if (colours > near_ties + allowed(kOtherColoursAllowed, pixels)) {
      throw StageFailure(
          kFailed,
          fmt::format("{} of {} pixels have colours other than those of the reference, by up to {}",
                      colours, pixels, largest));
    }
    Row& verification = parts["verification"];
    verification["pixels_compared"] = pixels;
    verification["label_mismatches"] = differing - near_ties;
    verification["near_ties"] = near_ties;
    verification["other_colours"] = colours;
    verification["same_as_raw"] = true;
    verification["samples"] = samples;
    verification["psnr_db"] = mse > 0 ? Row(-10 * std::log10(mse)) : Row(nullptr);
    verification["largest_difference"] = largest;
    parts["exact_after_frames"] = frames;
  }

  /// The picture that the renderer holds.
  void compare_picture(RenderTruth& truth, const Shot& shot, PictureErrors& errors) {
    const gpu::Image image = renderer_->read_image();
    const gpu::ImageDifference from_raw = gpu::compare(truth.raw(shot), image);
    if (!from_raw.identical()) {
      throw StageFailure(
          kFailed,
          fmt::format(
              "at part {} of the path the picture is not that of codec raw: {} of {} labels "
              "differ, colours by up to {}",
              shot.part, from_raw.labels, from_raw.pixels, from_raw.largest));
    }
    errors.add(truth.errors_of_raw(shot));  // which is the same picture
  }

  /// A frame of the held view as it is timed: drawn whole from the filled cache. Where the cache is
  /// too small for that, some pixels stay incomplete, and the row says how many.
  void check_held(RenderTruth& truth, PictureErrors& errors, Row& parts) {
    const gpu::Settled settled = settle(held_shot());
    fill_cache(*renderer_);
    const gpu::FrameResult frame = renderer_->render(held_camera());
    Row& held = parts["held"];
    held["key"] = scene_.held;
    held["exact_after_frames"] = settled.frames;
    held["compared"] = frame.incomplete == 0;
    if (frame.incomplete == 0) compare_picture(truth, held_shot(), errors);
  }

  /// The first frames after the camera has jumped to a view that the cache has not seen, compared
  /// with the truth.
  void measure_jump(RenderTruth& truth, Row& parts) {
    if (choice_.jump_frames == 0) return;
    settle({kJumpFrom, 1, scene_.lod_bias});
    const Shot shot{kJumpTo, 1, scene_.lod_bias};
    const gpu::Image expected = truth.raw(shot);
    Row& frames = parts["jump"]["frames"] = Row::array();
    for (std::uint32_t frame = 0; frame < choice_.jump_frames; ++frame) {
      const gpu::FrameResult result = renderer_->render(scene_.path.at(shot.part));
      const gpu::ImageDifference difference = gpu::compare(expected, renderer_->read_image());
      frames.push_back({{"psnr_db", psnr_or_null(difference)},
                        {"label_mismatches", difference.labels},
                        {"incomplete", result.incomplete},
                        {"ms", 1e3 * result.gpu_seconds}});
    }
    parts["jump"]["pixels"] = expected.pixels();
  }

  /// Levels of detail and few samples as an error of the picture: against level bias 0 and many
  /// samples.
  void measure_error(RenderTruth& truth, Row& parts) {
    if (!choice_.picture_error) return;
    const Shot best{kErrorPart, choice_.shading == gpu::Shading::kAo ? kBestSamples : 1, 0};
    settle({kErrorPart, choice_.ao_samples, scene_.lod_bias});
    const gpu::ImageDifference difference =
        gpu::compare(truth.reference(best), renderer_->read_image());
    Row& error = parts["picture_error"];
    error["psnr_db"] = psnr_or_null(difference);
    error["ssim"] = difference.ssim;
    error["label_mismatches"] = difference.labels;
    error["pixels"] = difference.pixels;
    error["samples_of_truth"] = best.samples;
  }

  /// Counters of the whole path, and of three exact pictures from an empty cache beside the work
  /// that these need at least.
  void count_work(RenderTruth& truth, const codecs::GpuEncoding& encoding, Row& parts) {
    const auto counting = make_renderer(encoding, true);
    show_scene(*counting);
    std::map<std::string, std::uint64_t> first;
    gpu::NeededWork needed;
    for (const double part : kCheckedParts) {
      counting->clear_cache();
      counting->clear_counters();
      counting->settle(scene_.path.at(part));
      for (const auto& [name, count] : counting->read_counters()) first[name] += count;
      const gpu::NeededWork here = truth.needed({part, 1, scene_.lod_bias});
      needed.visits += here.visits;
      needed.distinct_cells += here.distinct_cells;
      needed.distinct_bricks += here.distinct_bricks;
    }
    Row& row = parts["needed"];
    row["visits"] = needed.visits;
    row["distinct_cells"] = needed.distinct_cells;
    row["distinct_bricks"] = needed.distinct_bricks;
    row["cells_read"] = first["cells_read"];
    row["cells_decoded"] = first["cells_decoded"];
    row["bytes_touched"] = 4 * first["words_touched"];
    row["decoded_over_needed"] = needed.distinct_cells == 0
                                     ? Row(nullptr)
                                     : Row(static_cast<double>(first["cells_decoded"]) /
                                           static_cast<double>(needed.distinct_cells));
    if (choice_.count_path) {
      counting->clear_cache();
      counting->clear_counters();
      for (std::uint32_t frame = 0; frame < scene_.frames; ++frame)
        counting->render(scene_.camera(frame));
      for (const auto& [name, count] : counting->read_counters()) parts["counters"][name] = count;
    }
    if (choice_.held_frames > 0) count_held(*counting, parts["held"]);
  }

  /// What a frame of the held view still reads and decodes, once the cache is filled.
  void count_held(gpu::Renderer& counting, Row& held) const {
    fill_cache(counting);
    counting.clear_counters();
    const gpu::FrameResult frame = counting.render(held_camera());
    std::map<std::string, std::uint64_t> work;
    for (const auto& [name, count] : counting.read_counters()) work[name] = count;
    held["cells_read"] = work["cells_read"];
    held["cells_decoded"] = work["cells_decoded"];
    held["bytes_touched"] = 4 * work["words_touched"];
    held["cache_complete"] =
        has_cache() ? Row(frame.incomplete == 0 && work["cells_decoded"] == 0) : Row(nullptr);
  }

  WorkerSpec spec_;
  const volumes::VolumeSource& truth_;
  const RenderChoice& choice_;
  gpu::Scene scene_;
  std::unique_ptr<gpu::Device> device_;
  std::unique_ptr<gpu::Renderer> renderer_;
};

}  // namespace

std::unique_ptr<StageRun> make_render_run(const WorkerSpec& spec,
                                          const volumes::VolumeSource& truth) {
  if (!spec.render) throw StageFailure(kFailed, "a render stage without its choices");
  return std::make_unique<RenderRun>(spec, truth);
}

}  // namespace cvr::experiments
