// BC4 (RGTC1, unsigned), the format of the Khronos Data Format Specification 1.3, section 19.1: two
// endpoints of 8 bits and sixteen 3-bit indices into a palette between them.
//
// The encoder starts from least and largest value, assigns each texel its nearest entry, fits the
// endpoints to the assignment by least squares, and repeats while that helps; it does so with six
// values between the endpoints and with four and the constants 0 and 255, and keeps what has the
// smaller squared error.
#include "codecs/bc4/bc4.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "codecs/scalar_blocks/scalar_blocks.hpp"

namespace cvr::codecs {

namespace {

using scalar_blocks::BlockCoder;
using scalar_blocks::BlockFormat;

constexpr unsigned kTexels = 16;
constexpr unsigned kRefinements = 4;

using Palette = std::array<double, 8>;

/// In units of 1/255. More than `second` in `first` means six values between them, else four and
/// the constants.
Palette palette_of(unsigned first, unsigned second) {
  Palette palette{static_cast<double>(first), static_cast<double>(second)};
  const unsigned steps = first > second ? 7 : 5;
  for (unsigned i = 1; i < steps; ++i)
    palette[i + 1] = static_cast<double>((steps - i) * first + i * second) / steps;
  if (steps == 5) {
    palette[6] = 0;
    palette[7] = 255;
  }
  return palette;
}

struct Trial {
  unsigned first = 0, second = 0;
  std::array<std::uint8_t, kTexels> indices{};
  double error = 0;
};

Trial assign(const double* values, unsigned first, unsigned second, bool whole) {
  Trial trial{first, second, {}, 0};
  Palette palette = palette_of(first, second);
  if (whole)
    std::ranges::transform(palette, palette.begin(), [](double p) { return std::floor(p + 0.5); });
  for (unsigned t = 0; t < kTexels; ++t) {
    double least = std::abs(values[t] - palette[0]);
    for (std::uint8_t i = 1; i < 8; ++i) {
      const double distance = std::abs(values[t] - palette[i]);
      if (distance >= least) continue;
      least = distance;
      trial.indices[t] = i;
    }
    trial.error += least * least;
  }
  return trial;
}

unsigned to_endpoint(double value) {
  return static_cast<unsigned>(std::clamp(std::floor(value + 0.5), 0.0, 255.0));
}

/// Endpoints that fit the assignment of a trial best. The order of the endpoints, which tells the
/// palettes apart, is kept.
std::pair<unsigned, unsigned> fit(const double* values, const Trial& trial) {
  const unsigned steps = trial.first > trial.second ? 7 : 5;
  double aa = 0, ab = 0, bb = 0, av = 0, bv = 0;
  for (unsigned t = 0; t < kTexels; ++t) {
    const unsigned index = trial.indices[t];
    if (steps == 5 && index >= 6) continue;
    const double b = index == 0 ? 0 : index == 1 ? 1 : static_cast<double>(index - 1) / steps;
    const double a = 1 - b;
    aa += a * a;
    ab += a * b;
    bb += b * b;
    av += a * values[t];
    bv += b * values[t];
  }
  const double determinant = aa * bb - ab * ab;
  if (determinant < 1e-9) return {trial.first, trial.second};
  const unsigned first = to_endpoint((av * bb - bv * ab) / determinant),
                 second = to_endpoint((bv * aa - av * ab) / determinant);
  return (first > second) == (steps == 7) ? std::pair(first, second)
                                          : std::pair(trial.first, trial.second);
}

Trial refine(const double* values, Trial best, bool whole) {
  for (unsigned i = 0; i < kRefinements && best.error > 0; ++i) {
    const auto [first, second] = fit(values, best);
    const Trial next = assign(values, first, second, whole);
    if (next.error >= best.error) break;
    best = next;
  }
  return best;
}

/// `whole`: decoded values are rounded to integers.
Trial encode_block(const double* values, bool whole) {
  const auto [least, largest] = std::minmax_element(values, values + kTexels);
  const unsigned low = to_endpoint(*least), high = to_endpoint(*largest);
  Trial best = refine(values, assign(values, high, low, whole), whole);
  if (best.error == 0) return best;
  double inner_least = 255, inner_largest = 0;
  for (unsigned t = 0; t < kTexels; ++t) {
    if (values[t] < 0.5 || values[t] >= 254.5) continue;
    inner_least = std::min(inner_least, values[t]);
    inner_largest = std::max(inner_largest, values[t]);
  }
  if (inner_least > inner_largest) inner_least = inner_largest = 0;  // all are constants
  const Trial other = refine(
      values, assign(values, to_endpoint(inner_least), to_endpoint(inner_largest), whole), whole);
  return other.error < best.error ? other : best;
}

std::uint64_t to_word(const Trial& trial) {
  std::uint64_t word = trial.first | trial.second << 8;
  for (unsigned t = 0; t < kTexels; ++t) word |= std::uint64_t{trial.indices[t]} << (16 + 3 * t);
  return word;
}

template <class T>
class Bc4Coder final : public BlockCoder {
 public:
  explicit Bc4Coder(const ScalarRange& range) : range_(range) {}

  Expected<std::uint64_t> encode(const std::byte* voxels, unsigned count,
                                 std::uint64_t* words) override {
    double values[kTexels];
    for (unsigned k = 0; k < count; ++k) {
      const T* block = reinterpret_cast<const T*>(voxels) + k * kTexels;
      std::transform(block, block + kTexels, values,
                     [&](T voxel) { return 255 * position_in(range_, voxel); });
      words[k] = to_word(encode_block(values, sizeof(T) == 1));
    }
    return count;
  }

  Expected<void> decode(std::span<const std::byte> words, unsigned first, unsigned count,
                        std::byte* voxels) override {
    for (unsigned k = 0; k < count; ++k) {
      const std::uint64_t word = word_at(words, first + k);
      std::array<T, 8> entries;
      std::ranges::transform(palette_of(word & 255, word >> 8 & 255), entries.begin(),
                             [&](double p) { return voxel_of(p); });
      T* block = reinterpret_cast<T*>(voxels) + k * kTexels;
      for (unsigned t = 0; t < kTexels; ++t) block[t] = entries[word >> (16 + 3 * t) & 7];
    }
    return {};
  }

  bool has_voxels() const override { return true; }
  std::uint64_t voxel(std::span<const std::byte> words, unsigned block, unsigned index) override {
    const std::uint64_t word = word_at(words, block);
    const T value = voxel_of(palette_of(word & 255, word >> 8 & 255)[word >> (16 + 3 * index) & 7]);
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof value);
    return bits;
  }

 private:
  T voxel_of(double entry) const { return voxel_at<T>(range_, entry / 255); }
  static std::uint64_t word_at(std::span<const std::byte> words, unsigned block) {
    std::uint64_t word;
    std::memcpy(&word, words.data() + 8 * block, sizeof word);
    return word;
  }

  ScalarRange range_;
};

class Bc4Format final : public BlockFormat {
 public:
  Bc4Format(VoxelType type, const ScalarRange& range) : type_(type), range_(range) {}
  Extent block() const override { return {4, 4, 1}; }
  std::uint64_t bits() const override { return 64; }
  std::unique_ptr<BlockCoder> coder() const override {
    switch (type_) {
      case VoxelType::kU8:
        return std::make_unique<Bc4Coder<std::uint8_t>>(ScalarRange{0, 255});
      case VoxelType::kU16:
        return std::make_unique<Bc4Coder<std::uint16_t>>(range_);
      case VoxelType::kI16:
        return std::make_unique<Bc4Coder<std::int16_t>>(range_);
      default:
        return std::make_unique<Bc4Coder<float>>(range_);
    }
  }

 private:
  VoxelType type_;
  ScalarRange range_;
};

class Bc4Codec final : public scalar_blocks::ScalarBlocksCodec {
 public:
  const Traits& traits() const override {
    static const Traits kTraits{
        .id = "bc4",
        .version = 1,
        .family = "bc4",
        .summary = "BC4, the texture format: slices in blocks of 4x4 at 4 bits per voxel",
        .lossless = false,
        .types = volumes::kScalarTypes,
        .access = Granularity::kVoxel,
        .levels_of_detail = false,
        .stored_compressed = false,
        .front = scalar_blocks::kFront};
    return kTraits;
  }
  std::span<const ParameterSpec> parameters() const override { return {}; }

 protected:
  std::unique_ptr<const BlockFormat> format(VoxelType type, const Parameters&,
                                            const ScalarRange& range) const override {
    return std::make_unique<Bc4Format>(type, range);
  }
};

}  // namespace

const Codec& bc4_codec() {
  static const Bc4Codec kCodec;
  return kCodec;
}

}  // namespace cvr::codecs
