// Every codec of the registry against damaged bytes: flipped, truncated, spliced, overwritten with extreme
// values. The envelope's checksums are made right again, so that the damage reaches the codec. Nothing may
// crash, read outside (the sanitised build sees that: all bytes lie in blocks of exactly their size), take
// seconds, or hold more memory than a small file can excuse.
//
// Deterministic: mutation k of an encoding is the same in every run; a failure names k. tests/fuzz/targets
// holds the same for libFuzzer.
#include <gtest/gtest.h>
#include <xxhash.h>

#include <chrono>
#include <cstring>

#include "codecs/registry.hpp"
#include "tests/fuzz/exercise.hpp"
#include "tests/fuzz/mutation/allocation_watch.hpp"
#include "tests/zoo/zoo.hpp"

namespace cvr::fuzz {
namespace {

using codecs::Codec;
using codecs::Parameters;
using Bytes = std::vector<std::byte>;

// The largest window of the general-purpose compressors is 64 MiB (LZMA, level 9); the rest is for everything else.
constexpr std::size_t kMostBytes = std::size_t{68} << 20;
constexpr std::chrono::seconds kMostSeconds{5};

/// A stream of random numbers.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : seed_(seed) {}
  std::uint64_t roll(std::uint64_t sides) { return zoo::random_at(seed_, next_++) % sides; }

 private:
  std::uint64_t seed_;
  std::uint64_t next_ = 0;
};

/// Values at which sizes, offsets and counts go wrong.
std::uint32_t extreme(Dice& dice, std::size_t size) {
  const auto near = static_cast<std::uint32_t>(size / 4);
  const std::uint32_t values[] = {
      0,           1,           2,           3,        0x7fffffffu, 0x80000000u, 0xffffffffu, 0xfffffffeu,
      0x3fffffffu, 0x40000000u, 0x20000000u, 0x10001u, 0xffffu,     near,        near - 1,    near + 1};
  return values[dice.roll(std::size(values))];
}

void mutate_once(Bytes& bytes, const Bytes& other, Dice& dice) {
  if (bytes.empty()) return;
  // Headers are where the decisions are: half of the damage goes to the first 256 bytes.
  const auto place = [&](std::size_t width) {
    const std::size_t room = bytes.size() < width ? 0 : bytes.size() - width + 1;
    if (room == 0) return std::size_t{0};
    return static_cast<std::size_t>(dice.roll(dice.roll(2) == 0 ? std::min<std::size_t>(room, 256) : room));
  };
  switch (dice.roll(8)) {
    case 0:
      bytes[place(1)] ^= std::byte{1} << dice.roll(8);
      break;
    case 1:
      bytes[place(1)] = static_cast<std::byte>(dice.roll(256));
      break;
    case 2:
      bytes.resize(dice.roll(bytes.size() + 1));
      break;
    case 3:
      bytes.resize(bytes.size() + dice.roll(64));
      break;
    case 4: {  // the head of one encoding, the tail of another
      const std::size_t cut = dice.roll(std::min(bytes.size(), other.size()) + 1);
      bytes.resize(cut);
      bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(cut), other.end());
      break;
    }
    case 5: {  // a piece copied onto another place
      const std::size_t length = 1 + dice.roll(std::min<std::size_t>(bytes.size(), 64));
      const std::size_t from = dice.roll(bytes.size() - length + 1);
      std::memmove(bytes.data() + dice.roll(bytes.size() - length + 1), bytes.data() + from, length);
      break;
    }
    default: {
      if (bytes.size() < 4) break;
      const std::size_t at = place(4) / 4 * 4;
      std::uint32_t word = 0;
      std::memcpy(&word, bytes.data() + at, 4);
      word = dice.roll(3) == 0 ? word + static_cast<std::uint32_t>(dice.roll(9)) - 4
                               : extreme(dice, bytes.size());
      std::memcpy(bytes.data() + at, &word, 4);
      break;
    }
  }
}

Bytes mutated(const Bytes& bytes, const Bytes& other, std::uint64_t seed) {
  Dice dice(seed);
  Bytes damaged = bytes;
  for (std::uint64_t times = 1 + dice.roll(3); times > 0; --times) mutate_once(damaged, other, dice);
  damaged.shrink_to_fit();
  return damaged;
}

/// Makes sizes and checksums of an envelope right (offsets: codecs/container.hpp). Damage to the header's own
/// text remains.
void repair_envelope(Bytes& file) {
  std::uint32_t header_size = 0;
  if (file.size() < 96) return;
  std::memcpy(&header_size, file.data() + 12, 4);
  if (header_size > file.size() || header_size < 96) return;
  const std::uint64_t payload_size = file.size() - header_size;
  std::memcpy(file.data() + 16, &payload_size, 8);
  const std::uint64_t payload_hash = XXH3_64bits(file.data() + header_size, payload_size);
  std::memcpy(file.data() + 24, &payload_hash, 8);
  std::memset(file.data() + 32, 0, 8);
  const std::uint64_t header_hash = XXH3_64bits(file.data(), header_size);
  std::memcpy(file.data() + 32, &header_hash, 8);
}

template <class Body>
void watch(Body&& body) {
  const auto begin = std::chrono::steady_clock::now();
  start_watching();
  EXPECT_NO_THROW(body());
  const std::size_t held = most_bytes_held();
  if (counts_allocations()) {
    ASSERT_LE(held, kMostBytes);
  }
  ASSERT_LE(std::chrono::steady_clock::now() - begin, kMostSeconds);
}

struct Subject {
  const Codec* codec;
  Parameters parameters;
  std::uint64_t mutations;  ///< of each encoding
};

/// Each codec with its defaults and every corner of its parameters; a codec gets a few thousand mutations over all of them.
std::vector<Subject> subjects() {
  std::vector<Subject> all;
  for (const Codec* codec : codecs::all_codecs()) {
    const std::vector<Parameters> corners = zoo::parameter_corners(*codec);
    for (const Parameters& parameters : corners)
      all.push_back({codec, parameters, 1500 / corners.size() + 100});
  }
  return all;
}

struct Encoding {
  volumes::VolumeInfo info;
  Bytes file, payload;
};

class Mutation : public testing::TestWithParam<Subject> {
 protected:
  void SetUp() override {
    for (const char* name : {"odd_sides_5x7x9_u16", "one_voxel_u32", "labels_above_2pow32_u64",
                             "brick_part_outside_u8", "extreme_scalars_i16", "nan_inf_zeros_denormals_f32",
                             "noise_of_scalars_u8", "scalars_of_60_decades_f32"}) {
      const zoo::Specimen& specimen = zoo::specimen(name);
      if (!zoo::accepts(*GetParam().codec, specimen)) continue;
      const volumes::Volume volume = specimen.volume();
      const auto encoded =
          codecs::encode(*GetParam().codec, volumes::MemorySource(volume), GetParam().parameters, 1);
      if (!encoded) continue;  // a corner that does not suit the volume
      const auto bytes = encoded->bytes.bytes();
      const auto opened = codecs::open_file(bytes);
      ASSERT_TRUE(opened) << opened.error().message;
      const auto payload = opened->stream.payload;
      encodings_.push_back({specimen.info, {bytes.begin(), bytes.end()}, {payload.begin(), payload.end()}});
    }
    if (encodings_.empty()) GTEST_SKIP() << "no encoding with these parameters";
  }
  std::uint64_t mutations() const { return GetParam().mutations; }
  const Encoding& after(std::size_t i) const { return encodings_[(i + 1) % encodings_.size()]; }

  std::vector<Encoding> encodings_;
};

TEST_P(Mutation, DamagedPayloadsAreRefusedOrDecoded) {
  std::uint64_t accepted = 0;
  for (std::size_t i = 0; i < encodings_.size(); ++i) {
    for (std::uint64_t k = 0; k < mutations(); ++k) {
      SCOPED_TRACE(testing::Message() << "encoding " << i << ", mutation " << k);
      const Bytes bytes = mutated(encodings_[i].payload, after(i).payload, 1000 * i + k);
      watch([&] {
        accepted +=
            exercise_payload(*GetParam().codec, {encodings_[i].info, GetParam().parameters, bytes}) ? 1 : 0;
      });
      if (HasFatalFailure()) return;
    }
  }
  RecordProperty("accepted", static_cast<int>(accepted));
}

TEST_P(Mutation, DamagedFilesWithRepairedChecksumsAreRefusedOrDecoded) {
  for (std::size_t i = 0; i < encodings_.size(); ++i) {
    for (std::uint64_t k = 0; k < mutations() / 2; ++k) {
      SCOPED_TRACE(testing::Message() << "encoding " << i << ", mutation " << k);
      Bytes bytes = mutated(encodings_[i].file, after(i).file, 77000 + 1000 * i + k);
      repair_envelope(bytes);
      watch([&] { exercise_file(bytes); });
      if (HasFatalFailure()) return;
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
  const volumes::Volume volume = zoo::specimen("extreme_scalars_i16").volume();
  const Codec& codec = *codecs::all_codecs().front();
  const auto encoded =
      codecs::encode(codec, volumes::MemorySource(volume), zoo::parameter_corners(codec)[0], 1).value();
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
  const volumes::Volume volume = zoo::specimen("odd_sides_5x7x9_u16").volume();
  const Codec& codec = *codecs::all_codecs().front();
  const auto encoded =
      codecs::encode(codec, volumes::MemorySource(volume), zoo::parameter_corners(codec)[0], 1).value();
  Bytes shifted(1);
  shifted.insert(shifted.end(), encoded.bytes.bytes().begin(), encoded.bytes.bytes().end());
  const auto opened = codecs::open_file(std::span(shifted).subspan(1));
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, codecs::ErrorCode::kBadArgument);
}

TEST(RepairedEnvelope, ReachesTheCodec) {
  const volumes::Volume volume = zoo::specimen("odd_sides_5x7x9_u16").volume();
  const Codec& codec = *codecs::all_codecs().front();
  const auto encoded =
      codecs::encode(codec, volumes::MemorySource(volume), zoo::parameter_corners(codec)[0], 1).value();
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

INSTANTIATE_TEST_SUITE_P(Registry, Mutation, testing::ValuesIn(subjects()), [](const auto& info) {
  return zoo::test_name(*info.param.codec, info.param.parameters);
});

}  // namespace
}  // namespace cvr::fuzz
