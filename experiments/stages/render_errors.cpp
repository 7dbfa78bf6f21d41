#include "experiments/stages/render_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

namespace {

constexpr float kOtherColour = 1.5F / 255;  ///< difference of a channel
constexpr double kNearTiesAllowed = 1e-4;   ///< of the pixels: rays pass a hundred edges and more
constexpr double kOtherColoursAllowed =
    1e-4;  ///< of the pixels: secondary rays have near-ties that nobody looks for
constexpr double kLeastPsnr =
    60;  ///< dB, of single against double precision; a wrong voxel value shows long before

std::uint64_t count_other_colours(const gpu::Image& a, const gpu::Image& b) {
  std::uint64_t count = 0;
  for (std::size_t pixel = 0; pixel < a.pixels(); ++pixel) {
    bool other = false;
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i)
      other = other || std::abs(a.colour[i] - b.colour[i]) > kOtherColour;
    count += other ? 1 : 0;
  }
  return count;
}

/// One pixel may always differ: of a small image it is more than its share.
std::uint64_t allowed(double share, std::uint64_t pixels) {
  return 1 + static_cast<std::uint64_t>(share * static_cast<double>(pixels));
}

}  // namespace

void ImageErrors::add(const ImageErrors& other) {
  images += other.images;
  pixels += other.pixels;
  labels += other.labels;
  near_ties += other.near_ties;
  colours += other.colours;
  largest = std::max(largest, other.largest);
  largest_mse = std::max(largest_mse, other.largest_mse);
  sum_mse += other.sum_mse;
  sum_ssim += other.sum_ssim;
}

ImageErrors errors_of(const gpu::Image& expected, const gpu::Image& found) {
  const gpu::ImageDifference difference = gpu::compare(expected, found);
  return {.images = 1,
          .pixels = difference.pixels,
          .labels = difference.labels,
          .near_ties = 0,
          .colours = count_other_colours(expected, found),
          .largest = difference.largest,
          .largest_mse = difference.mse,
          .sum_mse = difference.mse,
          .sum_ssim = difference.ssim};
}

Nullable<double> psnr_of(double mse) {
  return mse > 0 ? Nullable<double>(-10 * std::log10(mse)) : std::nullopt;
}

void require_label_images(const ImageErrors& errors) {
  if (errors.labels > errors.near_ties) {
    throw StageFailure(
        kFailed,
        fmt::format(
            "{} of {} pixels have labels other than those of the reference, {} of them near-ties",
            errors.labels, errors.pixels, errors.near_ties));
  }
  if (errors.near_ties > allowed(kNearTiesAllowed, errors.pixels)) {
    throw StageFailure(kFailed,
                       fmt::format("{} of {} pixels are near-ties, more than 1 and one in 10^4",
                                   errors.near_ties, errors.pixels));
  }
  if (errors.colours > errors.near_ties + allowed(kOtherColoursAllowed, errors.pixels)) {
    throw StageFailure(
        kFailed,
        fmt::format("{} of {} pixels have colours other than those of the reference, by up to {}",
                    errors.colours, errors.pixels, errors.largest));
  }
}

void require_scalar_image(const ImageErrors& errors, double part) {
  if (errors.largest_mse == 0) return;
  const double psnr = -10 * std::log10(errors.largest_mse);
  if (psnr >= kLeastPsnr) return;
  throw StageFailure(kFailed,
                     fmt::format("at part {} of the path the image is {:.1f} dB from that of the "
                                 "reference, {:.0f} at least were expected",
                                 part, psnr, kLeastPsnr));
}

}  // namespace cvr::experiments
