// ASTC (Nystad et al.: Adaptive Scalable Texture Compression, HPG 2012; Khronos Data Format
// Specification 1.3, section 23), 3D blocks of one component by Arm's astcenc. Blocks are
// independent, so a run of them is given to the library as one image in which they stand side by
// side, wherever they are in the volume.
#include "codecs/astc/astc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "codecs/astc/contexts.hpp"
#include "codecs/astc/library.hpp"
#include "codecs/scalar_blocks/scalar_blocks.hpp"

namespace cvr::codecs {

namespace {

using scalar_blocks::BlockCoder;
using scalar_blocks::BlockFormat;
using scalar_blocks::kRunBlocks;

constexpr unsigned kBlockBytes = 16;
constexpr unsigned kComponents = 4;  // of a texel in astcenc's images
constexpr unsigned kLargestEdge = 6;

/// The voxels of a run as astcenc's image: u8 as they are, others as floats in 0..1.
template <class T>
class AstcCoder final : public BlockCoder {
  static constexpr bool kAsStored = std::is_same_v<T, std::uint8_t>;
  using Texel = std::conditional_t<kAsStored, std::uint8_t, float>;

 public:
  AstcCoder(unsigned edge, int effort, const ScalarRange& range)
      : edge_(edge),
        effort_(effort),
        range_(range),
        texels_(std::size_t{kRunBlocks} * edge * edge * edge * kComponents) {}

  Expected<std::uint64_t> encode(const std::byte* voxels, unsigned count,
                                 std::uint64_t* words) override {
    if (!encoder_) encoder_ = astc::take_context({edge_, effort_});
    const T* from = reinterpret_cast<const T*>(voxels);
    each_texel(count, [&](Texel* texel, std::size_t voxel) {
      if constexpr (kAsStored) {
        texel[0] = from[voxel];
      } else {
        texel[0] = static_cast<Texel>(position_in(range_, from[voxel]));
      }
      texel[1] = texel[2] = texel[3] = texel[0];
    });
    constexpr astcenc_swizzle kLuminance{ASTCENC_SWZ_R, ASTCENC_SWZ_R, ASTCENC_SWZ_R,
                                         ASTCENC_SWZ_1};
    astcenc_image image = image_of(count);
    const auto result = astcenc_compress_image(encoder_.get(), &image, &kLuminance,
                                               reinterpret_cast<std::uint8_t*>(words),
                                               std::size_t{count} * kBlockBytes, 0);
    astcenc_compress_reset(encoder_.get());
    if (result != ASTCENC_SUCCESS)
      return fail(ErrorCode::kOutOfMemory,
                  fmt::format("astcenc: {}", astcenc_get_error_string(result)));
    return count * kBlockBytes / sizeof *words;
  }

  Expected<void> decode(std::span<const std::byte> words, unsigned first, unsigned count,
                        std::byte* voxels) override {
    if (!decoder_) decoder_ = astc::take_context({edge_, astc::kDecodeOnly});
    constexpr astcenc_swizzle kUnchanged{ASTCENC_SWZ_R, ASTCENC_SWZ_G, ASTCENC_SWZ_B,
                                         ASTCENC_SWZ_A};
    astcenc_image image = image_of(count);
    const auto result = astcenc_decompress_image(
        decoder_.get(),
        reinterpret_cast<const std::uint8_t*>(words.data()) + std::size_t{first} * kBlockBytes,
        std::size_t{count} * kBlockBytes, &image, &kUnchanged, 0);
    astcenc_decompress_reset(decoder_.get());
    if (result != ASTCENC_SUCCESS)
      return fail(ErrorCode::kOutOfMemory,
                  fmt::format("astcenc: {}", astcenc_get_error_string(result)));
    T* to = reinterpret_cast<T*>(voxels);
    each_texel(count, [&](const Texel* texel, std::size_t voxel) {
      if constexpr (kAsStored) {
        to[voxel] = texel[0];
      } else {
        to[voxel] = voxel_at<T>(range_, texel[0]);
      }
    });
    return {};
  }

 private:
  /// Calls f(texel, index of its voxel in the run) for each texel of the first `count` blocks.
  template <class F>
  void each_texel(unsigned count, F&& f) {
    Texel* texel = texels_.data();
    for (unsigned z = 0; z < edge_; ++z) {
      for (unsigned y = 0; y < edge_; ++y) {
        for (unsigned k = 0; k < count; ++k) {
          std::size_t voxel = edge_ * (y + edge_ * (z + std::size_t{edge_} * k));
          for (unsigned x = 0; x < edge_; ++x, texel += kComponents) f(texel, voxel++);
        }
      }
    }
  }

  astcenc_image image_of(unsigned count) {
    for (unsigned z = 0; z < edge_; ++z)
      slices_[z] = texels_.data() + std::size_t{z} * count * edge_ * edge_ * kComponents;
    return {count * edge_, edge_, edge_, kAsStored ? ASTCENC_TYPE_U8 : ASTCENC_TYPE_F32,
            slices_.data()};
  }

  unsigned edge_;
  int effort_;
  ScalarRange range_;
  astc::Context encoder_, decoder_;
  std::vector<Texel> texels_;
  std::array<void*, kLargestEdge> slices_{};
};

class AstcFormat final : public BlockFormat {
 public:
  AstcFormat(VoxelType type, unsigned edge, int effort, const ScalarRange& range)
      : type_(type), edge_(edge), effort_(effort), range_(range) {}
  Extent block() const override { return {edge_, edge_, edge_}; }
  std::uint64_t bits() const override { return 8 * kBlockBytes; }
  std::unique_ptr<BlockCoder> coder() const override {
    switch (type_) {
      case VoxelType::kU8:
        return std::make_unique<AstcCoder<std::uint8_t>>(edge_, effort_, range_);
      case VoxelType::kU16:
        return std::make_unique<AstcCoder<std::uint16_t>>(edge_, effort_, range_);
      case VoxelType::kI16:
        return std::make_unique<AstcCoder<std::int16_t>>(edge_, effort_, range_);
      default:
        return std::make_unique<AstcCoder<float>>(edge_, effort_, range_);
    }
  }

 private:
  VoxelType type_;
  unsigned edge_;
  int effort_;
  ScalarRange range_;
};

int effort_of(const std::string& name) {
  if (name == "fastest") return static_cast<int>(ASTCENC_PRE_FASTEST);
  if (name == "fast") return static_cast<int>(ASTCENC_PRE_FAST);
  if (name == "medium") return static_cast<int>(ASTCENC_PRE_MEDIUM);
  return static_cast<int>(ASTCENC_PRE_THOROUGH);
}

class AstcCodec final : public scalar_blocks::ScalarBlocksCodec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits{
        .id = "astc",
        .version = 1,
        .family = "astc",
        .summary = "ASTC by astcenc, the texture format: blocks of 3x3x3 to 6x6x6 in 128 bits",
        .lossless = false,
        .types = volumes::kScalarTypes,
        .access = Granularity::kBlock,
        .levels_of_detail = false,
        .stored_compressed = false,
        .front = scalar_blocks::kFront};
    return kTraits;
  }
  std::span<const ParameterSpec> parameters() const override {
    static const std::array kParameters{
        ParameterSpec{
            .name = "edge",
            .type = ParameterType::kInteger,
            .default_value = "6",
            .choices = {6, 5, 4, 3},
            .description = "edge of a block in voxels: 0.59, 1.02, 2 or 4.74 bits per voxel"},
        ParameterSpec{.name = "effort",
                      .type = ParameterType::kText,
                      .default_value = "fast",
                      .names = {"fastest", "fast", "medium", "thorough"},
                      .description = "of the encoder's search, by astcenc's presets"}};
    return kParameters;
  }

 protected:
  std::unique_ptr<const BlockFormat> format(VoxelType type, const Parameters& parameters,
                                            const ScalarRange& range) const override {
    return std::make_unique<AstcFormat>(type, static_cast<unsigned>(parameters.integer("edge")),
                                        effort_of(parameters.text("effort")), range);
  }
};

}  // namespace

const Codec& astc_codec() {
  static const AstcCodec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
