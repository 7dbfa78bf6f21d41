// The errors of images against what they should be: the one place where images of the render stage
// are compared and judged.
#pragma once

#include <cstdint>

#include "experiments/results/result.hpp"
#include "gpu/image.hpp"

namespace cvr::experiments {

/// What the comparison of images has found, all images together. Trivially copyable: it is left in
/// the scratch folder of a run.
struct ImageErrors {
  std::uint64_t images = 0, pixels = 0;
  std::uint64_t labels = 0;     ///< pixels whose labels differ
  std::uint64_t near_ties = 0;  ///< of these, where rounding decides (gpu/IMAGE.md)
  std::uint64_t colours = 0;    ///< pixels with a channel that differs by more than 1.5 / 255
  double largest = 0;           ///< channel difference of all images
  double largest_mse = 0;       ///< of the image that differs most
  double sum_mse = 0, sum_ssim = 0;
  void add(const ImageErrors& other);
  double mean_mse() const { return sum_mse / static_cast<double>(images); }
  double mean_ssim() const { return sum_ssim / static_cast<double>(images); }
};

/// Of one image; no near-ties are looked for.
ImageErrors errors_of(const gpu::Image& expected, const gpu::Image& found);

/// In dB, of a peak of 1. Equal images have none: null.
Nullable<double> psnr_of(double mse);

/// Throws StageFailure where labels or colours differ from the reference's by more than near-ties
/// and rounding explain.
void require_label_images(const ImageErrors& errors);
/// Throws StageFailure where an image of scalars is further from that of the reference than single
/// precision is from double. `part`: of the camera path, for the message.
void require_scalar_image(const ImageErrors& errors, double part);

}  // namespace cvr::experiments
