// Images of scalars.
//
// Checked at three cameras of the path: the image must be that of the reference in double precision
// of the decoded volume, but for rounding. The error that the codec makes in images is measured
// apart, against the reference of the original ("picture_error").
#include <fmt/format.h>

#include "experiments/stages/render_errors.hpp"
#include "experiments/stages/render_subject.hpp"
#include "gpu/scalars/reference.hpp"
#include "gpu/scalars/renderer.hpp"

namespace cvr::experiments {

namespace {

class ScalarSubject final : public RenderSubject {
 public:
  ScalarSubject(const RenderSetting& setting, const codecs::Decoder& decoder)
      : setting_(setting),
        decoder_(decoder),
        progressive_(decoder.progressive_access()),
        step_(step_of(setting.choice, progressive_)),
        original_(volumes::read_all(setting.truth)),
        range_(gpu::value_range(original_)) {}

  /// The images are compared with those of what it decodes to.
  void check_encoding(std::span<const std::byte>, Parts&) override {}
  void describe(Parts& parts) const override {
    if (progressive_ == nullptr) return;
    parts.step = {std::string(progressive_->step_name(step_)), progressive_->step_bytes(step_)};
  }
  std::unique_ptr<gpu::FrameRenderer> make_renderer() override {
    return checked(gpu::ScalarRenderer::make(setting_.device, checked(decoder_.gpu_samples(step_)),
                                             setting_.truth.info(), range_,
                                             setting_.options(false)));
  }
  gpu::Image reference(const Shot& shot) override { return image_of(original_, shot); }

  void check_images(gpu::FrameRenderer& renderer, Parts& parts) override {
    volumes::VolumeSink sink(setting_.truth.info());
    checked(progressive_ == nullptr ? decoder_.decode(0, cores(), sink)
                                    : progressive_->decode_step(step_, cores(), sink));
    const volumes::Volume decoded = sink.take();
    ImageErrors drawing, codec;
    renderer.clear_counters();
    for (const double part : kCheckedParts) {
      const Shot shot{part, 1, setting_.scene.lod_bias};
      setting_.settle(renderer, shot);
      const gpu::Image image = renderer.read_image();
      const ImageErrors errors = errors_of(image_of(decoded, shot), image);
      require_scalar_image(errors, part);
      drawing.add(errors);
      codec.add(errors_of(reference(shot), image));
    }
    Parts::Verification& verification = parts.verification.emplace();
    verification.pixels_compared = drawing.pixels;
    verification.psnr_db = psnr_of(drawing.mean_mse());
    verification.largest_difference = drawing.largest;
    Parts::PictureError& error = parts.picture_error.emplace();
    error.psnr_db = psnr_of(codec.mean_mse());
    error.ssim = codec.mean_ssim();
    error.largest = codec.largest;
    error.pixels = codec.pixels;
    parts.counters = counted(renderer);
  }

 private:
  static unsigned step_of(const RenderChoice& choice,
                          const codecs::ProgressiveAccess* progressive) {
    const unsigned steps = progressive == nullptr ? 1 : progressive->steps();
    if (choice.step && (progressive == nullptr || *choice.step >= steps))
      throw StageFailure(kUnsupported,
                         fmt::format("step {}: the encoding has {}", *choice.step, steps));
    return choice.step.value_or(steps - 1);
  }
  gpu::Image image_of(const volumes::Volume& volume, const Shot& shot) const {
    return gpu::render_scalars(volume, setting_.scene, range_, setting_.scene.path.at(shot.part),
                               cores());
  }

  const RenderSetting& setting_;
  const codecs::Decoder& decoder_;
  const codecs::ProgressiveAccess* progressive_;  ///< nullptr: one step
  unsigned step_;
  volumes::Volume original_;
  gpu::ValueRange range_;
};

}  // namespace

std::unique_ptr<RenderSubject> make_scalar_subject(const RenderSetting& setting,
                                                   const codecs::Decoder& decoder) {
  return std::make_unique<ScalarSubject>(setting, decoder);
}

}  // namespace cvr::experiments
