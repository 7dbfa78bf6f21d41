// Every codec of the registry against damaged bytes: bits flipped, truncated, spliced, headers that
// lie. Each damage is done three times: to the payload, to the whole file with the envelope's
// checksums made right again, so that the damage reaches the codec, and to the whole file as it is,
// which must then be refused. Nothing may crash, read outside (the sanitised build sees that: all
// bytes lie in blocks of exactly their size), hang, or hold more memory than a small file can
// excuse.
//
// Deterministic: damage k of a codec is the same in every run; a failure names k. ./check does a
// share of them,
//   CVRBENCH_DAMAGES=10000 build/bin/test_fuzz
// that many of each kind for each codec, and says how they ended: ctest -L slow. tests/fuzz/targets
// holds the same for libFuzzer.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <xxhash.h>

#include <array>
#include <cstdlib>
#include <cstring>

#include "codecs/registry.hpp"
#include "tests/fuzz/envelope.hpp"
#include "tests/fuzz/exercise.hpp"
#include "tests/fuzz/watch.hpp"
#include "tests/samples/refusals.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::fuzz {
namespace {

using codecs::Codec;
using codecs::Parameters;
using Bytes = std::vector<std::byte>;

// The largest window of the general-purpose compressors is 64 MiB (LZMA, level 9); the rest is for
// everything else.
constexpr std::size_t kMostBytes = std::size_t{68} << 20;
constexpr std::uint64_t kShare = 300;  ///< damages of each kind and codec in ./check

enum class Damage : std::uint8_t { kFlip, kTruncation, kSplice, kLie };
constexpr std::array kDamages{Damage::kFlip, Damage::kTruncation, Damage::kSplice, Damage::kLie};
constexpr std::array kDamageNames{"bit flips", "truncations", "splices", "lying headers"};

/// A stream of random numbers.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : seed_(seed) {}
  std::uint64_t roll(std::uint64_t sides) { return samples::random_at(seed_, next_++) % sides; }

 private:
  std::uint64_t seed_;
  std::uint64_t next_ = 0;
};

/// Values at which sizes, offsets and counts go wrong.
std::uint32_t extreme(Dice& dice, std::size_t size) {
  const auto near = static_cast<std::uint32_t>(size / 4);
  const std::uint32_t values[] = {0,           1,           2,           3,
                                  0x7fffffffu, 0x80000000u, 0xffffffffu, 0xfffffffeu,
                                  0x3fffffffu, 0x40000000u, 0x20000000u, 0x10001u,
                                  0xffffu,     near,        near - 1,    near + 1};
  return values[dice.roll(std::size(values))];
}

/// Headers are where the decisions are: half of the damage goes to the first 256 bytes.
std::size_t place(const Bytes& bytes, std::size_t width, Dice& dice) {
  const std::size_t room = bytes.size() < width ? 0 : bytes.size() - width + 1;
  if (room == 0) return 0;
  return dice.roll(dice.roll(2) == 0 ? std::min<std::size_t>(room, 256) : room);
}

void flip(Bytes& bytes, Dice& dice) {
  std::byte& byte = bytes[place(bytes, 1, dice)];
  byte = dice.roll(2) == 0 ? byte ^ (std::byte{1} << dice.roll(8))
                           : static_cast<std::byte>(dice.roll(256));
}

/// Shorter, or longer by zeros.
void truncate(Bytes& bytes, Dice& dice) {
  bytes.resize(dice.roll(4) == 0 ? bytes.size() + dice.roll(64) : dice.roll(bytes.size() + 1));
}

/// The head of one encoding before the tail of another, or a piece copied onto another place.
void splice(Bytes& bytes, const Bytes& other, Dice& dice) {
  if (dice.roll(2) == 0) {
    const std::size_t cut = dice.roll(std::min(bytes.size(), other.size()) + 1);
    bytes.resize(cut);
    bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(cut), other.end());
    return;
  }
  const std::size_t length = 1 + dice.roll(std::min<std::size_t>(bytes.size(), 64));
  const std::size_t from = dice.roll(bytes.size() - length + 1);
  std::memmove(bytes.data() + dice.roll(bytes.size() - length + 1), bytes.data() + from, length);
}

/// A size, offset or count that is off by a little or by all there is.
void lie(Bytes& bytes, Dice& dice) {
  if (bytes.size() < 4) return;
  const std::size_t at = place(bytes, 4, dice) / 4 * 4;
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  word = dice.roll(3) == 0 ? word + static_cast<std::uint32_t>(dice.roll(9)) - 4
                           : extreme(dice, bytes.size());
  std::memcpy(bytes.data() + at, &word, 4);
}

/// One to three times; the more often the rarer.
Bytes damaged(const Bytes& bytes, const Bytes& other, Damage damage, std::uint64_t seed) {
  Dice dice(seed);
  Bytes result = bytes;
  for (std::uint64_t times = 1 + dice.roll(3) / 2 + dice.roll(2); times > 0 && !result.empty();
       --times) {
    switch (damage) {
      case Damage::kFlip:
        flip(result, dice);
        break;
      case Damage::kTruncation:
        truncate(result, dice);
        break;
      case Damage::kSplice:
        splice(result, other, dice);
        break;
      case Damage::kLie:
        lie(result, dice);
        break;
    }
  }
  result.shrink_to_fit();
  return result;
}

/// Of each kind and codec; the test of all of them says how they ended.
std::uint64_t damages() {
  const char* asked = std::getenv("CVRBENCH_DAMAGES");
  return asked == nullptr ? kShare : std::strtoull(asked, nullptr, 10);
}

template <class Body>
void watch_small(Body&& body) {
  watch(0, body);
  if (counts_allocations() && !testing::Test::HasFatalFailure()) {
    ASSERT_LE(most_bytes_held(), kMostBytes);
  }
}

struct Encoding {
  volumes::VolumeInfo info;
  Parameters parameters;
  Bytes file, payload;
};

class Mutation : public testing::TestWithParam<const Codec*> {
 protected:
  /// Small volumes with the defaults and every corner of the codec's parameters.
  void SetUp() override {
    for (const char* name : {"odd_sides_5x7x9_u16", "one_voxel_u32", "labels_above_2pow32_u64",
                             "brick_part_outside_u8", "extreme_scalars_i16",
                             "nan_inf_zeros_denormals_f32", "noise_of_scalars_u8",
                             "scalars_of_60_decades_f32", "series_of_3_u16", "series_of_4_u8"}) {
      const samples::SampleVolume& sample = samples::sample(name);
      if (!samples::accepts(*GetParam(), sample)) continue;
      const volumes::Volume volume = sample.volume();
      for (const Parameters& parameters : samples::parameter_corners(*GetParam())) {
        const auto encoded =
            codecs::encode(*GetParam(), volumes::MemorySource(volume), parameters, 1);
        if (!encoded) {  // a corner that does not suit the volume
          ASSERT_TRUE(samples::is_listed_refusal(CVR_SOURCE_DIR "/tests/golden/refusals.txt",
                                                 *GetParam(), parameters, sample))
              << encoded.error().message;
          continue;
        }
        const auto bytes = encoded->bytes.bytes();
        const auto opened = codecs::open_file(bytes);
        ASSERT_TRUE(opened) << opened.error().message;
        const auto payload = opened->stream.payload;
        encodings_.push_back({sample.info,
                              parameters,
                              {bytes.begin(), bytes.end()},
                              {payload.begin(), payload.end()}});
      }
    }
    ASSERT_FALSE(encodings_.empty());
  }
  /// Walks all encodings, whatever share of them is asked for.
  const Encoding& encoding(std::uint64_t k) const {
    return encodings_[samples::random_at(91, k) % encodings_.size()];
  }

  std::vector<Encoding> encodings_;
};

TEST_P(Mutation, DamagedPayloadsAreRefusedOrDecoded) {
  for (const Damage damage : kDamages) {
    std::uint64_t accepted = 0;
    for (std::uint64_t k = 0; k < damages(); ++k) {
      SCOPED_TRACE(testing::Message()
                   << kDamageNames[static_cast<std::size_t>(damage)] << ", damage " << k);
      const Encoding& whole = encoding(k);
      const Bytes bytes = damaged(whole.payload, encoding(k + 1).payload, damage,
                                  4 * k + static_cast<std::uint64_t>(damage));
      watch_small([&] {
        accepted += exercise_payload(*GetParam(), {whole.info, whole.parameters, bytes}) ? 1 : 0;
      });
      if (HasFatalFailure()) return;
    }
    if (std::getenv("CVRBENCH_DAMAGES") != nullptr) {
      fmt::print("{:16} {:13} of payloads: {:6} refused {:6} decoded\n", GetParam()->traits().id,
                 kDamageNames[static_cast<std::size_t>(damage)], damages() - accepted, accepted);
    }
  }
}

TEST_P(Mutation, DamagedFilesAreRefusedAndWithRepairedChecksumsRefusedOrDecoded) {
  for (const Damage damage : kDamages) {
    std::uint64_t unchanged = 0, accepted = 0;
    for (std::uint64_t k = 0; k < damages(); ++k) {
      SCOPED_TRACE(testing::Message()
                   << kDamageNames[static_cast<std::size_t>(damage)] << ", damage " << k);
      const Encoding& whole = encoding(k);
      Bytes bytes = damaged(whole.file, encoding(k + 1).file, damage,
                            1000003 + 4 * k + static_cast<std::uint64_t>(damage));
      // A head spliced before its own tail is a file as good as any.
      const bool same = bytes == whole.file || bytes == encoding(k + 1).file;
      unchanged += same ? 1 : 0;
      watch_small(
          [&] { ASSERT_EQ(codecs::open_file(bytes).has_value(), same) << "a silent error"; });
      if (HasFatalFailure()) return;
      repair_envelope(bytes);
      watch_small([&] { accepted += exercise_file(bytes) ? 1 : 0; });
      if (HasFatalFailure()) return;
    }
    if (std::getenv("CVRBENCH_DAMAGES") != nullptr) {
      fmt::print(
          "{:16} {:13} of files: {:6} refused as they are, {:4} unchanged; checksums repaired: "
          "{:6} refused {:6} decoded\n",
          GetParam()->traits().id, kDamageNames[static_cast<std::size_t>(damage)],
          damages() - unchanged, unchanged, damages() - accepted, accepted);
    }
  }
}

TEST_P(Mutation, EveryTruncationOfAFileIsRefused) {
  const Bytes& file = encodings_.front().file;
  for (std::size_t size = 0; size < file.size(); size += 1 + size / 64) {
    const Bytes shorter(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(exercise_file(shorter)) << size;
  }
  EXPECT_TRUE(exercise_file(file));
}

TEST(OpenFile, RefusesLabelsOfSignedOrFloatingType) {
  const volumes::Volume volume = samples::sample("extreme_scalars_i16").volume();
  const Codec& codec = *codecs::all_codecs().front();
  const auto encoded =
      codecs::encode(codec, volumes::MemorySource(volume), samples::parameter_corners(codec)[0], 1)
          .value();
  Bytes bytes(encoded.bytes.bytes().begin(), encoded.bytes.bytes().end());
  constexpr std::size_t kKindAt = 45;
  ASSERT_EQ(bytes[kKindAt], static_cast<std::byte>(volumes::VolumeKind::kScalars));
  bytes[kKindAt] = static_cast<std::byte>(volumes::VolumeKind::kLabels);
  repair_envelope(bytes);
  const auto opened = codecs::open_file(bytes);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, codecs::ErrorCode::kUnsupported);
}

TEST(OpenFile, RefusesBytesOutOfAlignment) {
  const volumes::Volume volume = samples::sample("odd_sides_5x7x9_u16").volume();
  const Codec& codec = *codecs::all_codecs().front();
  const auto encoded =
      codecs::encode(codec, volumes::MemorySource(volume), samples::parameter_corners(codec)[0], 1)
          .value();
  Bytes shifted(1);
  shifted.insert(shifted.end(), encoded.bytes.bytes().begin(), encoded.bytes.bytes().end());
  const auto opened = codecs::open_file(std::span(shifted).subspan(1));
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, codecs::ErrorCode::kBadArgument);
}

TEST(RepairedEnvelope, ReachesTheCodec) {
  const volumes::Volume volume = samples::sample("odd_sides_5x7x9_u16").volume();
  const Codec& codec = *codecs::all_codecs().front();
  const auto encoded =
      codecs::encode(codec, volumes::MemorySource(volume), samples::parameter_corners(codec)[0], 1)
          .value();
  Bytes bytes(encoded.bytes.bytes().begin(), encoded.bytes.bytes().end());
  bytes.back() ^= std::byte{1};
  ASSERT_EQ(codecs::open_file(bytes).error().code, codecs::ErrorCode::kChecksum);
  repair_envelope(bytes);
  EXPECT_TRUE(codecs::open_file(bytes));
}

TEST(AllocationWatch, SeesWhatIsHeld) {
  if (!counts_allocations()) GTEST_SKIP() << "a sanitizer has its own allocator";
  start_watching();
  {
    const std::vector<char> block(1 << 20);
    EXPECT_EQ(block.back(), 0);
  }
  volumes::Buffer grown(1 << 10);
  grown.resize(3 << 20);
  EXPECT_GE(most_bytes_held(), std::size_t{3} << 20);
  EXPECT_LT(most_bytes_held(), std::size_t{4} << 20);
}

INSTANTIATE_TEST_SUITE_P(Registry, Mutation,
                         testing::ValuesIn(codecs::all_codecs().begin(),
                                           codecs::all_codecs().end()),
                         [](const auto& info) { return samples::test_name(*info.param, {}); });

}  // namespace
}  // namespace cvr::fuzz
