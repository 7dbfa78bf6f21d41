// Pictures: 8-bit values, how two of them differ, and their files.
#include "gpu/image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "tests/samples/scratch_folder.hpp"
#include "volumes/error.hpp"

namespace cvr::gpu {
namespace {

Image grey(std::uint32_t width, std::uint32_t height, float value) {
  Image image{.width = width, .height = height};
  image.colour.assign(3 * image.pixels(), value);
  image.labels.assign(image.pixels(), 1);
  image.complete.assign(image.pixels(), 1);
  return image;
}

TEST(Images, EightBitsAreRoundedAndCut) {
  Image image = grey(2, 1, 0);
  image.colour = {0, 0.5F / 255 - 1e-4F, 0.5F / 255 + 1e-4F, 1, 1.5F, -1};
  EXPECT_THAT(image.rgb8(), testing::ElementsAre(0, 0, 1, 255, 255, 0));
  image.colour[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(image.rgb8()[0], 0);
}

TEST(Images, EqualOnesDoNotDiffer) {
  const ImageDifference difference = compare(grey(20, 20, 0.3F), grey(20, 20, 0.3F));
  EXPECT_TRUE(difference.identical());
  EXPECT_EQ(difference.pixels, 400u);
  EXPECT_EQ(difference.mse, 0);
  EXPECT_NEAR(difference.ssim, 1, 1e-12);
}

TEST(Images, DifferencesAreShownAmplifiedAndWhiteAtMost) {
  Image a = grey(2, 1, 0.5F), b = a;
  b.colour = {0.5F, 0.51F, 0.49F, 0.7F, 0.3F, 2.0F};
  EXPECT_THAT(difference_rgb8(a, b, 8), testing::ElementsAre(0, 20, 20, 255, 255, 255));
  EXPECT_THAT(difference_rgb8(a, b, 1), testing::ElementsAre(0, 3, 3, 51, 51, 128))
      << "what is shown is at most white";
  EXPECT_THROW(difference_rgb8(a, grey(1, 2, 0.5F), 8), volumes::InputError);
}

TEST(Images, KnownDifferences) {
  const Image a = grey(16, 12, 0.25F);
  Image b = grey(16, 12, 0.75F);
  b.labels[5] = 2;
  const ImageDifference difference = compare(a, b);
  EXPECT_FALSE(difference.identical());
  EXPECT_EQ(difference.labels, 1u);
  EXPECT_NEAR(difference.mse, 0.25, 1e-12);
  EXPECT_NEAR(difference.psnr, 6.020599913279624, 1e-9);
  EXPECT_NEAR(difference.largest, 0.5, 1e-12);
  // Windows without variance: only the term of the means is left.
  EXPECT_NEAR(difference.ssim, (2 * 0.25 * 0.75 + 1e-4) / (0.0625 + 0.5625 + 1e-4), 1e-9);
}

TEST(Images, OneChannelOfOnePixel) {
  const Image a = grey(10, 10, 0.5F);
  Image b = a;
  b.colour[3 * 42 + 1] = 0.625F;
  const ImageDifference difference = compare(a, b);
  EXPECT_NEAR(difference.mse, 0.015625 / 300, 1e-12);
  EXPECT_NEAR(difference.largest, 0.125, 1e-12);
  EXPECT_LT(difference.ssim, 1);
}

TEST(Images, SimilarityOfOppositePatterns) {
  Image a = grey(8, 8, 0), b = grey(8, 8, 0);
  for (std::size_t i = 0; i < a.pixels(); ++i) {
    const bool odd = (i % 8 + i / 8) % 2 != 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      a.colour[3 * i + channel] = odd ? 1 : 0;
      b.colour[3 * i + channel] = odd ? 0 : 1;
    }
  }
  // Means 1/2, variances 1/4, covariance -1/4.
  EXPECT_NEAR(compare(a, b).ssim, (-0.5 + 9e-4) / (0.5 + 9e-4), 1e-9);
}

TEST(Images, WhatIsNoNumberDiffersFromEverything) {
  Image a = grey(9, 9, 0.5F);
  a.colour[7] = std::numeric_limits<float>::quiet_NaN();
  const ImageDifference difference = compare(a, a);
  EXPECT_FALSE(difference.identical());
  EXPECT_GT(difference.mse, 0);
}

TEST(Images, OfDifferentSizesAreRefused) {
  EXPECT_THROW(compare(grey(4, 5, 0), grey(5, 4, 0)), volumes::InputError);
}

class ImageFiles : public testing::Test {
 protected:
  experiments::ScratchFolder folder_;
};

TEST_F(ImageFiles, PngComesBack) {
  std::vector<std::uint8_t> rgb(7 * 5 * 3);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<std::uint8_t>(i * 37);
  const std::string path = folder_ / "a.png";
  write_png(path, 7, 5, rgb);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&image, path.c_str()), 0);
  EXPECT_EQ(image.width, 7u);
  EXPECT_EQ(image.height, 5u);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> read(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, read.data(), 0, nullptr), 0);
  EXPECT_EQ(read, rgb);
}

TEST_F(ImageFiles, ErrorsNameTheFile) {
  const std::string path = folder_ / "none/a.png";
  const auto message = [&](auto&& write) -> std::string {
    try {
      write();
    } catch (const volumes::InputError& error) {
      return error.what();
    } catch (const volumes::OutputError& error) {
      return error.what();
    }
    return "no error";
  };
  const std::string unwritable = path + ": cannot write: there is no folder";
  EXPECT_THAT(message([&] { write_png(path, 1, 1, {1, 2, 3}); }), testing::StartsWith(unwritable));
  EXPECT_THAT(message([&] {
                write_png(folder_ / "b.png", 2, 1, {1, 2, 3});
              }),
              testing::HasSubstr("expected 6 bytes for an image of 2x1, found 3"));
  EXPECT_THAT(message([&] { write_label_image(path, grey(1, 1, 0)); }),
              testing::StartsWith(unwritable));
}

TEST_F(ImageFiles, LabelsAreLittleEndianWords) {
  Image image = grey(2, 1, 0);
  image.labels = {0x0102030405060708u, kNoLabel};
  const std::string path = folder_ / "labels.u64";
  write_label_image(path, image);
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(bytes,
            std::string("\x08\x07\x06\x05\x04\x03\x02\x01\xff\xff\xff\xff\xff\xff\xff\xff", 16));
}

}  // namespace
}  // namespace cvr::gpu
