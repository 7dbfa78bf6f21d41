// Images of labels.
//
// Checked at three cameras of the path: once settled, labels and colours must be exactly those of
// the codec `raw` without a cache on this device, and the labels those of the reference in double
// precision but for near-ties (gpu/IMAGE.md), of which there may be one, and one more in every 10^4
// pixels. Colours may differ from the reference's in one pixel of 10^4. What is counted (cells read
// and decoded, words touched) comes from a second renderer, whose kernels count; the timed one does
// not.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "experiments/stages/encoded_volume.hpp"
#include "experiments/stages/render_errors.hpp"
#include "experiments/stages/render_subject.hpp"
#include "experiments/stages/render_truth.hpp"
#include "gpu/caches/cache.hpp"
#include "gpu/renderer.hpp"

namespace cvr::experiments {

namespace {

constexpr double kJumpFrom = 0.0, kJumpTo = 0.5;
constexpr double kErrorPart =
    0.37;  ///< where images with fewer levels or samples are compared with the best
constexpr std::uint32_t kBestSamples = 256;  ///< of the best image with random rays
constexpr std::uint32_t kCheckedSamples =
    4;  ///< at most; more would make the check longer than the measurement

class LabelSubject final : public RenderSubject {
 public:
  LabelSubject(const RenderSetting& setting, const codecs::Decoder& decoder)
      : setting_(setting),
        choice_(setting.choice),
        scene_(setting.scene),
        encoding_(checked(decoder.gpu_encoding(choice_.brick, cores()))),
        truth_(setting.spec, setting.truth, setting.scene, setting.device) {}

  void check_encoding(std::span<const std::byte> file, Parts& parts) override {
    verify_once(setting_.spec, file, setting_.truth, parts);
  }
  std::unique_ptr<gpu::FrameRenderer> make_renderer() override { return make(false); }
  gpu::Image reference(const Shot& shot) override { return truth_.reference(shot); }

  void check_images(gpu::FrameRenderer& renderer, Parts& parts) override {
    const std::uint32_t samples = std::min(choice_.ao_samples, kCheckedSamples);
    std::uint64_t frames = 0;
    ImageErrors errors;
    if (!traits().exact) draw_path(renderer);
    for (const double part : kCheckedParts) {
      const Shot shot{part, samples, scene_.lod_bias};
      const gpu::Settled settled = traits().exact
                                       ? setting_.settle(renderer, shot)
                                       : renderer.settle(scene_.path.at(shot.part), shot.samples);
      frames = std::max<std::uint64_t>(frames, settled.frames);
      compare_image(renderer, shot, errors);
    }
    if (choice_.warm_frames > 0) check_fixed(renderer, errors, parts);
    if (traits().exact) require_label_images(errors);
    Parts::Verification& verification = *parts.verification;
    verification.pixels_compared = errors.pixels;
    verification.label_mismatches = errors.labels - errors.near_ties;
    verification.near_ties = errors.near_ties;
    verification.other_colours = errors.colours;
    if (same_as_raw_) verification.same_as_raw = true;
    verification.samples = samples;
    verification.psnr_db = psnr_of(errors.largest_mse);
    verification.largest_difference = errors.largest;
    parts.exact_after_frames = frames;
  }

  void measure(gpu::FrameRenderer& renderer, Parts& parts) override {
    measure_jump(renderer, parts);
    measure_error(renderer, parts);
    count_work(parts);
  }

 private:
  const gpu::CacheTraits& traits() const { return *gpu::find_cache(choice_.access); }

  std::unique_ptr<gpu::FrameRenderer> make(bool instrumented) const {
    return checked(gpu::Renderer::make(setting_.device, encoding_, setting_.truth.info(),
                                       setting_.options(instrumented)));
  }

  /// Wrong pixels of a mode that has them come from what it has met on its way.
  void draw_path(gpu::FrameRenderer& renderer) const {
    renderer.clear_cache();
    for (std::uint32_t frame = 0; frame < scene_.frames; ++frame)
      renderer.render(scene_.camera(frame));
  }

  /// The image that the renderer holds.
  void compare_image(const gpu::FrameRenderer& renderer, const Shot& shot, ImageErrors& errors) {
    const gpu::Image image = renderer.read_image();
    const std::optional<gpu::Image> raw =
        traits().exact ? truth_.raw(shot) : std::optional<gpu::Image>();
    if (!raw) return errors.add(truth_.errors_of_image(shot, image));
    const gpu::ImageDifference from_raw = gpu::compare(*raw, image);
    if (!from_raw.identical()) {
      throw StageFailure(
          kFailed, fmt::format("at part {} of the path the image is not that of codec raw: {} of "
                               "{} labels differ, colours by up to {}",
                               shot.part, from_raw.labels, from_raw.pixels, from_raw.largest));
    }
    errors.add(truth_.errors_of_raw(shot));  // which is the same image
    same_as_raw_ = true;
  }

  /// A frame of the fixed view as it is timed: drawn whole from the filled cache. Where the cache
  /// is too small for that, some pixels stay incomplete, and the row says how many.
  void check_fixed(gpu::FrameRenderer& renderer, ImageErrors& errors, Parts& parts) {
    const gpu::Settled settled = setting_.settle(renderer, setting_.fixed_shot());
    setting_.fill_cache(renderer);
    const gpu::FrameResult frame = renderer.render(setting_.fixed_camera());
    Parts::Held& held = parts.held.emplace();
    held.key = scene_.held;
    held.exact_after_frames = settled.frames;
    held.compared = frame.incomplete == 0;
    if (frame.incomplete == 0) compare_image(renderer, setting_.fixed_shot(), errors);
  }

  /// The first frames after the camera has jumped to a view that the cache has not seen, compared
  /// with the truth.
  void measure_jump(gpu::FrameRenderer& renderer, Parts& parts) {
    if (choice_.jump_frames == 0) return;
    setting_.settle(renderer, {kJumpFrom, 1, scene_.lod_bias});
    const Shot shot{kJumpTo, 1, scene_.lod_bias};
    const std::optional<gpu::Image> raw = truth_.raw(shot);
    const gpu::Image expected = raw ? *raw : truth_.reference(shot);
    Parts::Jump& jump = parts.jump.emplace();
    for (std::uint32_t frame = 0; frame < choice_.jump_frames; ++frame) {
      const gpu::FrameResult result = renderer.render(scene_.path.at(shot.part));
      const ImageErrors errors = errors_of(expected, renderer.read_image());
      jump.frames.push_back(
          {psnr_of(errors.mean_mse()), errors.labels, result.incomplete, 1e3 * result.gpu_seconds});
    }
    jump.pixels = expected.pixels();
  }

  /// Levels of detail and few samples as an error of the image: against level bias 0 and many
  /// samples.
  void measure_error(gpu::FrameRenderer& renderer, Parts& parts) {
    if (!choice_.image_error) return;
    const Shot best{kErrorPart, choice_.shading == gpu::Shading::kAo ? kBestSamples : 1, 0};
    setting_.settle(renderer, {kErrorPart, choice_.ao_samples, scene_.lod_bias});
    const ImageErrors errors = errors_of(truth_.reference(best), renderer.read_image());
    Parts::PictureError& error = parts.picture_error.emplace();
    error.psnr_db = psnr_of(errors.mean_mse());
    error.ssim = errors.mean_ssim();
    error.label_mismatches = errors.labels;
    error.pixels = errors.pixels;
    error.samples_of_truth = best.samples;
  }

  /// Counters of the whole path, and of three exact images from an empty cache beside the work that
  /// these need at least.
  void count_work(Parts& parts) {
    const auto counting = make(true);
    setting_.show_scene(*counting);
    std::map<std::string, std::uint64_t> first;
    gpu::NeededWork needed;
    for (const double part : kCheckedParts) {
      counting->clear_cache();
      counting->clear_counters();
      counting->settle(scene_.path.at(part));
      for (const auto& [name, count] : counting->read_counters()) first[name] += count;
      const gpu::NeededWork here = truth_.needed({part, 1, scene_.lod_bias});
      needed.visits += here.visits;
      needed.distinct_cells += here.distinct_cells;
      needed.distinct_bricks += here.distinct_bricks;
    }
    Parts::Needed& row = parts.needed.emplace();
    row.visits = needed.visits;
    row.distinct_cells = needed.distinct_cells;
    row.distinct_bricks = needed.distinct_bricks;
    row.cells_read = first["cells_read"];
    row.cells_decoded = first["cells_decoded"];
    row.bytes_touched = 4 * first["words_touched"];
    if (needed.distinct_cells > 0)
      row.decoded_over_needed =
          static_cast<double>(first["cells_decoded"]) / static_cast<double>(needed.distinct_cells);
    if (choice_.count_path) {
      counting->clear_cache();
      counting->clear_counters();
      for (std::uint32_t frame = 0; frame < scene_.frames; ++frame)
        counting->render(scene_.camera(frame));
      parts.counters = counted(*counting);
    }
    if (choice_.warm_frames > 0) count_fixed(*counting, *parts.held);
  }

  /// What a frame of the fixed view still reads and decodes, once the cache is filled.
  void count_fixed(gpu::FrameRenderer& counting, Parts::Held& held) const {
    setting_.fill_cache(counting);
    counting.clear_counters();
    const gpu::FrameResult frame = counting.render(setting_.fixed_camera());
    Named<std::uint64_t> work = counted(counting);
    held.cells_read = work["cells_read"];
    held.cells_decoded = work["cells_decoded"];
    held.bytes_touched = 4 * work["words_touched"];
    held.cache_complete.emplace();
    if (counting.keeps_voxels())
      held.cache_complete = Nullable<bool>(frame.incomplete == 0 && work["cells_decoded"] == 0);
  }

  const RenderSetting& setting_;
  const RenderChoice& choice_;
  const gpu::Scene& scene_;
  codecs::GpuEncoding encoding_;
  RenderTruth truth_;
  bool same_as_raw_ = false;
};

}  // namespace

std::unique_ptr<RenderSubject> make_label_subject(const RenderSetting& setting,
                                                  const codecs::Decoder& decoder) {
  return std::make_unique<LabelSubject>(setting, decoder);
}

}  // namespace cvr::experiments
