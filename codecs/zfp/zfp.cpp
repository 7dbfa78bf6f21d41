// zfp (Lindstrom: Fixed-rate compressed floating-point arrays, IEEE TVCG 2014), single blocks by
// libzfp's low-level calls; the order of the blocks, threads and the index are ours
// (codecs/scalar_blocks).
//
// Fixed rate: integers are promoted to int32 as libzfp's own zfp_promote_* do (centred, shifted up
// to 30 bits and a sign), which saves the block exponent of floats; the way back rounds to nearest
// where zfp_demote_* cut, which would darken by half a step. Fixed accuracy is defined for floats
// alone: integers are then promoted to float, exactly.
#include "codecs/zfp/zfp.hpp"

#include <zfp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "codecs/scalar_blocks/scalar_blocks.hpp"

namespace cvr::codecs {

namespace {

using scalar_blocks::BlockCoder;
using scalar_blocks::BlockFormat;
using scalar_blocks::kRunBlocks;

constexpr unsigned kEdge = 4;
constexpr unsigned kVoxels = kEdge * kEdge * kEdge;
/// No float block is longer: 9 bits of exponent and 32 bit planes of 64 bits, each with a group
/// test, and 64 more tests where coefficients become significant.
constexpr unsigned kLongestBlock = 2304;
static_assert(9 + 32 * (kVoxels + 1) + kVoxels <= kLongestBlock);

constexpr unsigned kSpareWords = 2;  // that libzfp may read ahead

struct Mode {
  unsigned least_bits, most_bits;  ///< of a block
  int least_exponent;              ///< of the bit planes that are stored
};

/// Integers as zfp's 31-bit integers, and back.
template <class T>
struct Integer {
  using Value = std::int32_t;
  static constexpr unsigned kShift = 31 - std::numeric_limits<std::make_unsigned_t<T>>::digits;
  static constexpr std::int32_t kCentre =
      std::is_signed_v<T> ? 0 : std::int32_t{1} << (std::numeric_limits<T>::digits - 1);
  static Value promote(T voxel) {
    return (static_cast<std::int32_t>(voxel) - kCentre) * (std::int32_t{1} << kShift);
  }
  static std::int64_t demote(Value value) {
    return ((std::int64_t{value} + (std::int64_t{1} << (kShift - 1))) >> kShift) + kCentre;
  }
};

/// Voxels as floats, and back.
template <class T>
struct Float {
  using Value = float;
  static Value promote(T voxel) { return static_cast<float>(voxel); }
  static float demote(Value value) {
    return std::is_floating_point_v<T> ? value : std::floor(value + 0.5F);
  }
};

void encode_block(zfp_stream* stream, const std::int32_t* values) {
  zfp_encode_block_int32_3(stream, values);
}
void encode_block(zfp_stream* stream, const float* values) {
  zfp_encode_block_float_3(stream, values);
}
void decode_block(zfp_stream* stream, std::int32_t* values) {
  zfp_decode_block_int32_3(stream, values);
}
void decode_block(zfp_stream* stream, float* values) { zfp_decode_block_float_3(stream, values); }

template <class T, class Promotion>
class ZfpCoder final : public BlockCoder {
 public:
  using Value = typename Promotion::Value;

  ZfpCoder(const Mode& mode, const ScalarRange& range)
      : least_(static_cast<T>(range.minimum)),
        largest_(static_cast<T>(range.maximum)),
        fixed_bits_(mode.least_bits == mode.most_bits ? mode.most_bits : 0),
        words_(mode.most_bits * kRunBlocks / 64 + 1 + kSpareWords),
        bits_(stream_open(words_.data(), words_.size() * sizeof words_[0]), &stream_close),
        stream_(zfp_stream_open(bits_.get()), &zfp_stream_close) {
    if (!bits_ || !stream_) throw std::bad_alloc();
    zfp_stream_set_params(stream_.get(), mode.least_bits, mode.most_bits, ZFP_MAX_PREC,
                          mode.least_exponent);
  }

  Expected<std::uint64_t> encode(const std::byte* voxels, unsigned count,
                                 std::uint64_t* words) override {
    zfp_stream_rewind(stream_.get());
    Value values[kVoxels];
    for (unsigned k = 0; k < count; ++k) {
      const T* block = reinterpret_cast<const T*>(voxels) + k * kVoxels;
      std::transform(block, block + kVoxels, values, Promotion::promote);
      encode_block(stream_.get(), values);
    }
    zfp_stream_flush(stream_.get());
    const std::size_t bytes =
        stream_size(bits_.get());  // whole words of the library's choice, at most of 8 bytes
    std::memcpy(words, words_.data(), bytes);
    return (bytes + 7) / 8;
  }

  Expected<void> decode(std::span<const std::byte> words, unsigned first, unsigned count,
                        std::byte* voxels) override {
    // Blocks of a fixed size are found by their number, others by decoding those before them. What
    // is read past the words of a run that was damaged is zero, as far as blocks can reach.
    const std::uint64_t begin = std::uint64_t{first} * fixed_bits_;
    const std::uint64_t first_word = begin / 64;
    const std::uint64_t end_word = fixed_bits_ == 0
                                       ? words.size() / 8
                                       : (begin + std::uint64_t{count} * fixed_bits_ + 63) / 64;
    const std::uint64_t held = end_word - first_word;
    std::memcpy(words_.data(), words.data() + 8 * first_word, 8 * held);
    std::memset(words_.data() + held, 0,
                8 * (fixed_bits_ == 0 ? words_.size() - held : kSpareWords));
    stream_rseek(bits_.get(), begin % 64);
    Value values[kVoxels];
    for (unsigned k = 0; fixed_bits_ == 0 && k < first; ++k) decode_block(stream_.get(), values);
    for (unsigned k = 0; k < count; ++k) {
      decode_block(stream_.get(), values);
      // Outside the range of the volume, infinities included, everything is nearer to the truth
      // when cut; NaN becomes the least.
      std::transform(
          values, values + kVoxels, reinterpret_cast<T*>(voxels) + k * kVoxels, [&](Value value) {
            const auto voxel = Promotion::demote(value);
            return voxel >= least_ ? voxel <= largest_ ? static_cast<T>(voxel) : largest_ : least_;
          });
    }
    if (fixed_bits_ == 0 && stream_rtell(bits_.get()) > 8 * words.size())
      return fail(ErrorCode::kMalformed, "a block leaves its run");
    return {};
  }

 private:
  T least_, largest_;    ///< of the volume
  unsigned fixed_bits_;  ///< 0: blocks differ in size
  std::vector<std::uint64_t> words_;
  std::unique_ptr<bitstream, decltype(&stream_close)> bits_;
  std::unique_ptr<zfp_stream, decltype(&zfp_stream_close)> stream_;
};

class ZfpFormat final : public BlockFormat {
 public:
  ZfpFormat(VoxelType type, const Parameters& parameters, const ScalarRange& range)
      : type_(type), range_(range), accuracy_(parameters.text("mode") == "accuracy") {
    const auto bits = static_cast<unsigned>(parameters.integer("block_bits"));
    mode_ = accuracy_
                ? Mode{1, kLongestBlock, static_cast<int>(parameters.integer("tolerance_log2"))}
                : Mode{bits, bits, ZFP_MIN_EXP};
  }
  Extent block() const override { return {kEdge, kEdge, kEdge}; }
  std::uint64_t bits() const override { return mode_.most_bits; }
  bool fixed_size() const override { return !accuracy_; }
  std::unique_ptr<BlockCoder> coder() const override {
    switch (type_) {
      case VoxelType::kU8:
        return make<std::uint8_t>();
      case VoxelType::kU16:
        return make<std::uint16_t>();
      case VoxelType::kI16:
        return make<std::int16_t>();
      default:
        return std::make_unique<ZfpCoder<float, Float<float>>>(mode_, range_);
    }
  }

 private:
  template <class T>
  std::unique_ptr<BlockCoder> make() const {
    if (accuracy_) return std::make_unique<ZfpCoder<T, Float<T>>>(mode_, range_);
    return std::make_unique<ZfpCoder<T, Integer<T>>>(mode_, range_);
  }

  VoxelType type_;
  ScalarRange range_;
  bool accuracy_;
  Mode mode_;
};

class ZfpCodec final : public scalar_blocks::ScalarBlocksCodec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits{
        .id = "zfp",
        .version = 1,
        .family = "zfp",
        .summary = "zfp by libzfp: transformed blocks of 4x4x4, fixed rate or fixed accuracy",
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
            .name = "mode",
            .type = ParameterType::kText,
            .default_value = "rate",
            .names = {"rate", "accuracy"},
            .description = "blocks of block_bits, or as many bits as tolerance_log2 takes"},
        ParameterSpec{
            .name = "block_bits",
            .type = ParameterType::kInteger,
            .default_value = "64",
            .minimum = 16,
            .maximum = 2048,
            .description =
                "with mode=rate: bits of a block of 64 voxels, so 64 is one bit per voxel"},
        ParameterSpec{
            .name = "tolerance_log2",
            .type = ParameterType::kInteger,
            .default_value = "0",
            .minimum = -160,
            .maximum = 127,
            .description =
                "with mode=accuracy: log2 of the largest absolute error allowed, in voxel values"}};
    return kParameters;
  }
  std::optional<double> promised_error(const Parameters& parameters) const override {
    if (parameters.text("mode") != "accuracy") return std::nullopt;
    return std::ldexp(1.0, static_cast<int>(parameters.integer("tolerance_log2")));
  }

 protected:
  std::unique_ptr<const BlockFormat> format(VoxelType type, const Parameters& parameters,
                                            const ScalarRange& range) const override {
    return std::make_unique<ZfpFormat>(type, parameters, range);
  }
};

}  // namespace

const Codec& zfp_codec() {
  static const ZfpCodec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
