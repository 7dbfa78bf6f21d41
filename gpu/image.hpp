// A rendered image and how two of them differ.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cvr::gpu {

inline constexpr std::uint64_t kNoLabel = UINT64_MAX;  ///< of a pixel that hit nothing

struct Image {
  std::uint32_t width = 0, height = 0;
  std::vector<float> colour;          ///< 3 floats a pixel, linear, rows from the top
  std::vector<std::uint64_t> labels;  ///< of the first visible cell, kNoLabel where none
  std::vector<std::uint8_t>
      complete;  ///< 1 where the pixel's value is final, 0 where a placeholder was met

  std::size_t pixels() const { return std::size_t{width} * height; }
  /// 3 bytes per pixel.
  std::vector<std::uint8_t> rgb8() const;
};

struct ImageDifference {
  std::uint64_t pixels = 0;
  std::uint64_t labels = 0;  ///< pixels whose labels differ
  double mse = 0;            ///< of the channels, in [0, 1]
  double psnr = 0;           ///< in dB, peak 1; only where mse > 0
  double ssim = 1;           ///< mean structural similarity of the luma, 8x8 windows of stride 4
  double largest = 0;        ///< largest channel difference
  bool identical() const { return labels == 0 && largest == 0; }
};

/// Both of the same size.
ImageDifference compare(const Image& a, const Image& b);
/// The absolute differences of the channels as they are shown, times `gain`, white at most; 3 bytes
/// a pixel. Both of the same size.
std::vector<std::uint8_t> difference_rgb8(const Image& a, const Image& b, double gain);

/// Writes 8-bit RGB. Throws InputError for a wrong number of bytes, OutputError for a file that
/// cannot be written.
void write_png(const std::string& path, std::uint32_t width, std::uint32_t height,
               const std::vector<std::uint8_t>& rgb);
/// u64 little endian, row by row from the top. Throws OutputError.
void write_label_image(const std::string& path, const Image& image);

}  // namespace cvr::gpu
