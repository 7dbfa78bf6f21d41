// The lossy peers against what their formats say: zfp against libzfp's own whole-array calls and
// its bound, BC4 against blocks made by hand, and the payload that they share against damage that
// only its own checks see.
#include <gtest/gtest.h>
#include <zfp.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::codecs {
namespace {

constexpr std::size_t kHeaderBytes = 32;

Payload encode(std::string_view id, const Volume& volume,
               const std::vector<std::string>& parameters = {}, unsigned threads = 1) {
  const Codec& codec = *find_codec(id);
  return codec
      .encode(volumes::MemorySource(volume),
              Parameters::parse(codec.parameters(), parameters).value(), threads)
      .value();
}

Expected<std::unique_ptr<Decoder>> open(std::string_view id, const VolumeInfo& info,
                                        std::span<const std::byte> payload,
                                        const std::vector<std::string>& parameters = {}) {
  const Codec& codec = *find_codec(id);
  return codec.open({info, Parameters::parse(codec.parameters(), parameters).value(), payload});
}

Volume decode(std::string_view id, const VolumeInfo& info, std::span<const std::byte> payload,
              const std::vector<std::string>& parameters = {}) {
  volumes::VolumeSink sink(info);
  const auto decoder = open(id, info, payload, parameters);
  if (!decoder) throw std::runtime_error(decoder.error().message);
  if (const auto done = (*decoder)->decode(0, 1, sink); !done)
    throw std::runtime_error(done.error().message);
  return sink.take();
}

VolumeInfo scalars(const Extent& extent, VoxelType type) {
  return {.extent = extent, .type = type, .kind = VolumeKind::kScalars, .voxel_unit = {}};
}

Volume wave(const Extent& extent) {
  Volume volume(scalars(extent, VoxelType::kF32));
  std::uint64_t i = 0;
  for (float& voxel : volume.voxels<float>()) {
    const auto x = static_cast<float>(i % extent.x),
               y = static_cast<float>(i / extent.x % extent.y);
    voxel = std::sin(0.3F * x) * std::cos(0.2F * y) +
            0.01F * static_cast<float>(i++ / (extent.x * extent.y));
  }
  return volume;
}

/// Sixteen blocks a layer of 64 voxels at 40 bits are whole words, so our runs are libzfp's stream
/// of the whole array.
TEST(Zfp, FixedRateIsLibzfpsStreamOfTheArray) {
  Volume volume = wave({16, 16, 12});
  const Payload ours = encode("zfp", volume, {"block_bits=40"});
  std::vector<std::uint64_t> words(ours.bytes.size() / 8 + 64);
  bitstream* bits = stream_open(words.data(), words.size() * 8);
  zfp_stream* stream = zfp_stream_open(bits);
  zfp_stream_set_params(stream, 40, 40, ZFP_MAX_PREC, ZFP_MIN_EXP);
  zfp_field* field = zfp_field_3d(volume.data(), zfp_type_float, 16, 16, 12);
  const std::size_t size = zfp_compress(stream, field);
  zfp_field_free(field);
  zfp_stream_close(stream);
  stream_close(bits);
  ASSERT_EQ(ours.bytes.size() - kHeaderBytes, size);
  EXPECT_EQ(std::memcmp(ours.bytes.data() + kHeaderBytes, words.data(), size), 0);
}

TEST(Zfp, BlocksHaveTheBitsAskedFor) {
  const Volume volume = wave({20, 12, 9});  // 15 blocks a layer, 3 layers
  for (const std::uint64_t bits : {16u, 17u, 64u, 100u, 2048u}) {
    const Payload payload = encode("zfp", volume, {"block_bits=" + std::to_string(bits)});
    EXPECT_EQ(payload.bytes.size(), kHeaderBytes + 3 * 8 * ((15 * bits + 63) / 64)) << bits;
  }
}

TEST(Zfp, MoreBitsNeverMakeTheErrorMuchLargerAndManyMakeItVanish) {
  const Volume volume = samples::sample("noise_of_scalars_u16").volume();
  double before = std::numeric_limits<double>::infinity();
  for (const char* bits :
       {"block_bits=64", "block_bits=256", "block_bits=640", "block_bits=1400"}) {
    const Volume decoded =
        decode("zfp", volume.info(), encode("zfp", volume, {bits}).bytes.bytes(), {bits});
    const double error = samples::error_of(volume, decoded).mean_squared;
    EXPECT_LT(error, before) << bits;
    before = error;
  }
  EXPECT_EQ(before, 0);
}

TEST(Zfp, AccuracyKeepsItsToleranceOnEverySpecimen) {
  const Codec& zfp = *find_codec("zfp");
  for (const samples::SampleVolume& sample : samples::sample_volumes()) {
    if (!samples::accepts(zfp, sample)) continue;
    const Volume volume = sample.volume();
    for (const int log2 : {-20, 0, 3, 10}) {
      const std::vector<std::string> parameters{"mode=accuracy",
                                                "tolerance_log2=" + std::to_string(log2)};
      const Volume decoded =
          decode("zfp", volume.info(), encode("zfp", volume, parameters).bytes.bytes(), parameters);
      // Floats have 24 bits: of wide volumes the least of them is the bound.
      double largest = 0;
      volumes::with_voxel_type(volume.info().type, [&]<class T>() {
        for (const T voxel : volume.voxels<T>())
          largest = std::max(largest, std::abs(static_cast<double>(voxel)));
      });
      const double bound = std::max(std::ldexp(1, log2), std::ldexp(largest, -22));
      EXPECT_LE(samples::error_of(volume, decoded).largest, bound) << sample.name << ' ' << log2;
    }
  }
}

TEST(Zfp, ConstantsAreExact) {
  for (const char* name : {"constant_scalars_u8", "constant_scalars_u16", "constant_scalars_i16"}) {
    const Volume volume = samples::sample(name).volume();
    const Volume decoded = decode("zfp", volume.info(), encode("zfp", volume).bytes.bytes());
    EXPECT_EQ(samples::error_of(volume, decoded).largest, 0) << name;
  }
}

/// A payload of one BC4 block.
Buffer bc4_payload(double least, double largest, std::uint64_t word) {
  const double header[4]{0, 0, least, largest};
  Buffer payload;
  payload.append(header, sizeof header);
  payload.append(&word, sizeof word);
  return payload;
}

std::uint64_t all_indices() {
  std::uint64_t bits = 0;
  for (unsigned t = 0; t < 16; ++t) bits |= std::uint64_t{t % 8} << (16 + 3 * t);
  return bits;
}

TEST(Bc4, DecodesBothPalettes) {
  const VolumeInfo info = scalars({4, 4, 1}, VoxelType::kU8);
  const Volume eight =
      decode("bc4", info, bc4_payload(0, 255, 240 | 100 << 8 | all_indices()).bytes());
  const std::uint8_t expected_eight[]{240, 100, 220, 200, 180, 160, 140, 120};
  const Volume six =
      decode("bc4", info, bc4_payload(0, 255, 50 | 200 << 8 | all_indices()).bytes());
  const std::uint8_t expected_six[]{50, 200, 80, 110, 140, 170, 0, 255};
  for (unsigned t = 0; t < 16; ++t) {
    EXPECT_EQ(eight.voxels<std::uint8_t>()[t], expected_eight[t % 8]) << t;
    EXPECT_EQ(six.voxels<std::uint8_t>()[t], expected_six[t % 8]) << t;
  }
}

TEST(Bc4, ScalesOtherTypesToTheirRange) {
  const VolumeInfo info = scalars({4, 4, 1}, VoxelType::kI16);
  const Volume decoded =
      decode("bc4", info, bc4_payload(-1000, 1550, 255 | 0 << 8 | all_indices()).bytes());
  EXPECT_EQ(decoded.voxels<std::int16_t>()[0], 1550);
  EXPECT_EQ(decoded.voxels<std::int16_t>()[1], -1000);
  EXPECT_EQ(decoded.voxels<std::int16_t>()[2], 1186);  // -1000 + 2550 * 6/7 = 1185.7
}

TEST(Bc4, RestoresWhatItsPalettesHold) {
  for (const char* name :
       {"constant_scalars_u8", "checkerboard_of_extremes_u8", "one_outlier_u8"}) {
    const Volume volume = samples::sample(name).volume();
    EXPECT_EQ(
        samples::error_of(volume, decode("bc4", volume.info(), encode("bc4", volume).bytes.bytes()))
            .largest,
        0)
        << name;
  }
  // Values between two ends and both constants at once: only the palette of six has them.
  Volume volume(scalars({4, 4, 1}, VoxelType::kU8));
  const std::uint8_t values[]{0, 255, 60, 110, 70, 80, 90, 100};
  for (unsigned t = 0; t < 16; ++t) volume.voxels<std::uint8_t>()[t] = values[t % 8];
  EXPECT_EQ(
      samples::error_of(volume, decode("bc4", volume.info(), encode("bc4", volume).bytes.bytes()))
          .largest,
      0);
}

TEST(Astc, LargerBlocksMakeFewerBytesAndLargerErrors) {
  const Volume volume = samples::sample("wave_of_scalars_u16").volume();
  std::uint64_t bytes = ~std::uint64_t{0};
  double error = -1;
  for (const char* edge : {"edge=3", "edge=4", "edge=5", "edge=6"}) {
    const Payload payload = encode("astc", volume, {edge});
    EXPECT_LT(payload.bytes.size(), bytes) << edge;
    bytes = payload.bytes.size();
    const double found =
        samples::error_of(volume, decode("astc", volume.info(), payload.bytes.bytes(), {edge}))
            .mean_squared;
    EXPECT_GT(found, error) << edge;
    error = found;
  }
}

TEST(ScalarBlocks, RefuseDamagedHeadersAndTables) {
  const Volume volume = wave({9, 10, 11});
  const std::vector<std::string> accuracy{"mode=accuracy", "tolerance_log2=-8"};
  const Payload whole = encode("zfp", volume, accuracy);
  const auto refusal = [&](std::size_t at, auto value) {
    Buffer damaged = whole.bytes;
    std::memcpy(damaged.data() + at, &value, sizeof value);
    const auto opened = open("zfp", volume.info(), damaged.bytes(), accuracy);
    return opened ? std::string("accepted") : opened.error().message;
  };
  using Limits = std::numeric_limits<double>;
  EXPECT_EQ(refusal(0, -1.0), "offset 0: expected errors of 0 or more");
  EXPECT_EQ(refusal(8, Limits::quiet_NaN()), "offset 0: expected errors of 0 or more");
  EXPECT_EQ(refusal(16, Limits::infinity()).substr(0, 36), "offset 16: expected a range of f32, ");
  EXPECT_EQ(refusal(24, 1e300).substr(0, 36), "offset 16: expected a range of f32, ");
  EXPECT_EQ(refusal(kHeaderBytes, std::uint64_t{1}).substr(0, 10), "offset 32:");
  EXPECT_EQ(refusal(kHeaderBytes + 8, ~std::uint64_t{0}).substr(0, 10), "offset 40:");
  EXPECT_NE(refusal(kHeaderBytes + 8 * 3, std::uint64_t{0}), "accepted");
}

}  // namespace
}  // namespace cvr::codecs
