#include "gpu/image.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "volumes/error.hpp"
#include "volumes/io/file.hpp"

namespace cvr::gpu {

using volumes::InputError;

namespace {

constexpr std::uint32_t kWindow = 8, kStride = 4;       ///< of the structural similarity
constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;  ///< its constants for values in [0, 1]
constexpr double kRed = 0.2126, kGreen = 0.7152, kBlue = 0.0722;  ///< luma of ITU-R BT.709

/// A channel as it is shown; what is no number counts as black.
double shown(float value) {
  return std::isnan(value) ? 0.0 : std::clamp(static_cast<double>(value), 0.0, 1.0);
}

std::vector<double> luma(const Image& image) {
  std::vector<double> values(image.pixels());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float* c = &image.colour[3 * i];
    values[i] = kRed * shown(c[0]) + kGreen * shown(c[1]) + kBlue * shown(c[2]);
  }
  return values;
}

/// Structural similarity of one window (Wang, Bovik, Sheikh, Simoncelli 2004) with equal weights.
double window_similarity(const double* a, const double* b, std::size_t row, std::uint32_t width,
                         std::uint32_t height) {
  double sum_a = 0, sum_b = 0, sum_aa = 0, sum_bb = 0, sum_ab = 0;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const double va = a[y * row + x], vb = b[y * row + x];
      sum_a += va, sum_b += vb, sum_aa += va * va, sum_bb += vb * vb, sum_ab += va * vb;
    }
  }
  const double n = static_cast<double>(width) * height;
  const double mean_a = sum_a / n, mean_b = sum_b / n;
  const double variance_a = sum_aa / n - mean_a * mean_a, variance_b = sum_bb / n - mean_b * mean_b;
  const double covariance = sum_ab / n - mean_a * mean_b;
  return (2 * mean_a * mean_b + kC1) * (2 * covariance + kC2) /
         ((mean_a * mean_a + mean_b * mean_b + kC1) * (variance_a + variance_b + kC2));
}

/// Mean over all whole windows; an image smaller than a window is one window.
double structural_similarity(const Image& a, const Image& b) {
  const std::vector<double> luma_a = luma(a), luma_b = luma(b);
  const std::uint32_t width = std::min(kWindow, a.width), height = std::min(kWindow, a.height);
  double sum = 0;
  std::uint64_t windows = 0;
  for (std::uint32_t y = 0; y + height <= a.height; y += kStride) {
    for (std::uint32_t x = 0; x + width <= a.width; x += kStride, ++windows) {
      const std::size_t at = std::size_t{y} * a.width + x;
      sum += window_similarity(&luma_a[at], &luma_b[at], a.width, width, height);
    }
  }
  return windows == 0 ? 1 : sum / static_cast<double>(windows);
}

void require_same_size(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) {
    throw InputError(fmt::format("expected two images of the same size, found {}x{} and {}x{}",
                                 a.width, a.height, b.width, b.height));
  }
}

}  // namespace

std::vector<std::uint8_t> Image::rgb8() const {
  std::vector<std::uint8_t> bytes(colour.size());
  std::transform(colour.begin(), colour.end(), bytes.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::lround(255 * shown(value)));
  });
  return bytes;
}

ImageDifference compare(const Image& a, const Image& b) {
  require_same_size(a, b);
  ImageDifference difference;
  difference.pixels = a.pixels();
  for (std::size_t i = 0; i < a.labels.size(); ++i) difference.labels += a.labels[i] != b.labels[i];
  double squares = 0;
  for (std::size_t i = 0; i < a.colour.size(); ++i) {
    const bool known = std::isfinite(a.colour[i]) && std::isfinite(b.colour[i]);
    const double raw =
        std::abs(static_cast<double>(a.colour[i]) - static_cast<double>(b.colour[i]));
    difference.largest = std::max(difference.largest, known ? raw : 1.0);
    const double seen = known ? shown(a.colour[i]) - shown(b.colour[i]) : 1.0;
    squares += seen * seen;
  }
  if (!a.colour.empty()) difference.mse = squares / static_cast<double>(a.colour.size());
  if (difference.mse > 0) difference.psnr = -10 * std::log10(difference.mse);
  difference.ssim = structural_similarity(a, b);
  return difference;
}

std::vector<std::uint8_t> difference_rgb8(const Image& a, const Image& b, double gain) {
  require_same_size(a, b);
  std::vector<std::uint8_t> bytes(a.colour.size());
  std::ranges::transform(a.colour, b.colour, bytes.begin(), [gain](float x, float y) {
    return static_cast<std::uint8_t>(std::lround(
        255 * std::min(1.0, gain * std::abs(static_cast<double>(shown(x)) - shown(y)))));
  });
  return bytes;
}

void write_png(const std::string& path, std::uint32_t width, std::uint32_t height,
               const std::vector<std::uint8_t>& rgb) {
  if (width == 0 || height == 0 || rgb.size() != std::size_t{3} * width * height) {
    throw InputError(fmt::format("{}: expected {} bytes for an image of {}x{}, found {}", path,
                                 std::size_t{3} * width * height, width, height, rgb.size()));
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = PNG_FORMAT_RGB;
  std::vector<std::byte> bytes(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr) == 0) {
    throw volumes::OutputError(fmt::format("{}: cannot write: {}", path, image.message));
  }
  volumes::OutputFile file(path);
  file.write(std::span(bytes).first(size));
  file.commit();
}

void write_label_image(const std::string& path, const Image& image) {
  volumes::OutputFile file(path);
  file.write(std::as_bytes(std::span(image.labels)));
  file.commit();
}

}  // namespace cvr::gpu
