// The payload of compresso by hand, and payloads that its encoder never writes.
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "codecs/codec.hpp"
#include "codecs/registry.hpp"
#include "volumes/source.hpp"

namespace cvr::codecs {
namespace {

const Codec& codec() { return *find_codec("compresso"); }
Parameters parameters(const std::vector<std::string>& assignments) {
  return Parameters::parse(codec().parameters(), assignments).value();
}

template <class T>
Volume volume_of(const Extent& extent, VoxelType type, const std::vector<T>& labels) {
  Volume volume({.extent = extent, .type = type, .voxel_unit = {}});
  std::memcpy(volume.data(), labels.data(), labels.size() * sizeof(T));
  return volume;
}

/// A payload written down field by field: the header's five numbers, then the sections.
struct Written {
  Buffer bytes;
  template <class T>
  Written& put(std::initializer_list<T> values) {
    for (const T value : values) bytes.append(&value, sizeof value);
    return *this;
  }
};
Written header(std::uint64_t ids, std::uint64_t windows, std::uint64_t locations,
               std::uint64_t words, std::uint32_t bytes) {
  Written written;
  written.put<std::uint64_t>({ids, windows, locations, words}).put<std::uint32_t>({bytes, 0});
  return written;
}

/// The volume 3 x 2 x 2 of u16 in windows of 2 x 2 x 1:
///   z = 0:  7 7 9    boundary:  . # .    voxel (1, 0) differs from its right neighbour
///           7 7 9               . # .
///   z = 1:  7 8 8    boundary:  # # .    (0, 0) right, (1, 0) down; (0, 1) and (1, 1) right
///           7 9 8               # # .
/// Slice 0: components {(0,0),(0,1)} = 7 and {(2,0),(2,1)} = 9. (1,0) and (1,1) take their left
/// neighbour's label. Slice 1: component {(2,0),(2,1)} = 8. Locations: (0,0) is 7 like the voxel
/// below: 4. (1,0) is 8 like its right: 1.
///          (0,1) is 7 like below: 4. (1,1) is 9: no neighbour that counts, so 9 + 7 = 16.
/// Windows: slice 0: x 0..1: bits 1 and 3 = 10; x 2: 0. Slice 1: all four bits = 15; 0.
Volume example() {
  return volume_of<std::uint16_t>({3, 2, 2}, VoxelType::kU16, {7, 7, 9, 7, 7, 9, 7, 8, 8, 7, 9, 8});
}
Written example_payload() {
  Written written = header(3, 3, 4, 4, 1);
  written.put<std::uint16_t>({7, 9, 8});      // ids
  written.put<std::uint8_t>({0, 10, 15});     // windows
  written.put<std::uint16_t>({4, 1, 4, 16});  // locations
  written.put<std::uint8_t>({2, 3, 4, 3});    // words: window 1, one empty, window 2, one empty
  return written;
}

Expected<Volume> decode(const VolumeInfo& info, const Parameters& given, const Buffer& payload) {
  auto decoder = codec().open({info, given, payload.bytes()});
  if (!decoder) return tl::unexpected(decoder.error());
  volumes::VolumeSink sink(info);
  if (auto ok = (*decoder)->decode(0, 1, sink); !ok) return tl::unexpected(ok.error());
  return sink.take();
}

TEST(Compresso, PayloadByHand) {
  const Volume volume = example();
  const auto given = parameters({"window=2,2,1"});
  const auto payload = codec().encode(volumes::MemorySource(volume), given, 1);
  ASSERT_TRUE(payload);
  const Written expected = example_payload();
  ASSERT_EQ(payload->bytes.size(), expected.bytes.size());
  for (std::size_t i = 0; i < expected.bytes.size(); ++i)
    EXPECT_EQ(payload->bytes.data()[i], expected.bytes.data()[i]) << i;
  EXPECT_EQ(payload->breakdown[ByteClass::kHeader], 40u);
  EXPECT_EQ(payload->breakdown[ByteClass::kPalette], 6u);
  EXPECT_EQ(payload->breakdown[ByteClass::kTables], 3u);
  EXPECT_EQ(payload->breakdown[ByteClass::kOperations], 12u);
  const auto decoded = decode(volume.info(), given, payload->bytes);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(std::memcmp(decoded->data(), volume.data(), volume.bytes().size()), 0);
}

TEST(Compresso, LargestLabelsTakeAnEscape) {
  // 2 x 1 x 1 of u8: voxel 0 is boundary. 248 + 7 = 255 still fits, 249 does not.
  for (const unsigned label : {248u, 249u, 255u}) {
    const Volume volume =
        volume_of<std::uint8_t>({2, 1, 1}, VoxelType::kU8, {static_cast<std::uint8_t>(label), 0});
    const auto payload = codec().encode(volumes::MemorySource(volume), parameters({}), 1);
    ASSERT_TRUE(payload);
    std::uint64_t locations = 0;
    std::memcpy(&locations, payload->bytes.data() + 16, 8);
    EXPECT_EQ(locations, label > 248 ? 2u : 1u);
    const auto decoded = decode(volume.info(), parameters({}), payload->bytes);
    ASSERT_TRUE(decoded);
    EXPECT_EQ(decoded->label({0, 0, 0}), label);
  }
}

TEST(Compresso, WordsWidenWithTheIndices) {
  // 1-voxel-high windows of 8 bits: 256 distinct windows do not fit words of 8 bits (indices up to
  // 127).
  std::vector<std::uint8_t> labels;
  for (unsigned row = 0; row < 256; ++row) {
    std::uint8_t label = 0;
    for (unsigned x = 0; x < 9; ++x) {
      labels.push_back(label);
      label ^= row >> (x % 8) & 1;
    }
  }
  // Each row is a slice, so that only differences along x count.
  const Volume volume = volume_of({9, 1, 256}, VoxelType::kU8, labels);
  const auto given = parameters({"window=8,1,1"});
  const auto payload = codec().encode(volumes::MemorySource(volume), given, 2);
  ASSERT_TRUE(payload);
  std::uint64_t windows = 0;
  std::uint32_t bytes = 0;
  std::memcpy(&windows, payload->bytes.data() + 8, 8);
  std::memcpy(&bytes, payload->bytes.data() + 32, 4);
  EXPECT_EQ(windows, 256u);
  EXPECT_EQ(bytes, 2u);
  const auto decoded = decode(volume.info(), given, payload->bytes);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(std::memcmp(decoded->data(), volume.data(), volume.bytes().size()), 0);
}

TEST(Compresso, RefusesWindowsOfMoreThan64Voxels) {
  const Volume volume = example();
  const auto refused =
      codec().encode(volumes::MemorySource(volume), parameters({"window=8,8,2"}), 1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBadArgument);
}

TEST(Compresso, RefusesPayloadsThatNoEncoderWrites) {
  const VolumeInfo info = example().info();
  const auto given = parameters({"window=2,2,1"});
  ASSERT_TRUE(decode(info, given, example_payload().bytes));
  // Offsets: header 0..39, ids 40..45, windows 46..48, locations 49..56, words 57..60.
  const std::tuple<std::size_t, std::uint8_t, ErrorCode, const char*> cases[] = {
      {0, 2, ErrorCode::kMalformed, "fewer ids than the sections fill"},
      {0, 200, ErrorCode::kTruncated, "more ids than bytes"},
      {7, 0xff, ErrorCode::kTruncated, "ids beyond any memory"},
      {15, 0xff, ErrorCode::kMalformed, "windows beyond any memory"},
      {32, 2, ErrorCode::kMalformed, "words wider than they need to be"},
      {32, 0, ErrorCode::kMalformed, "words of no bytes"},
      {36, 1, ErrorCode::kMalformed, "the zero"},
      {46, 10, ErrorCode::kMalformed, "windows that do not ascend"},
      {48, 16, ErrorCode::kMalformed, "a window with a fifth bit"},
      {49, 0, ErrorCode::kMalformed, "left of the first column"},
      {51, 2, ErrorCode::kMalformed, "up, which is reserved"},
      {51, 5, ErrorCode::kMalformed, "above the last slice"},
      {53, 3, ErrorCode::kMalformed, "down from the last row"},
      {55, 6, ErrorCode::kMalformed, "an escape at the end of the list"},
      {49, 6, ErrorCode::kMalformed, "an escape that takes the next voxel's location"},
      {57, 6, ErrorCode::kMalformed, "the index of no window"},
      {58, 1, ErrorCode::kMalformed, "a run of no windows"},
      {60, 5, ErrorCode::kMalformed, "a run beyond the last window"},
  };
  for (const auto& [at, value, code, what] : cases) {
    Buffer damaged = example_payload().bytes;
    damaged.data()[at] = static_cast<std::byte>(value);
    const auto decoded = decode(info, given, damaged);
    ASSERT_FALSE(decoded) << what;
    EXPECT_EQ(decoded.error().code, code) << what << ": " << decoded.error().message;
  }
  // Words that stop early, ids that are left over.
  Written early = header(3, 3, 4, 3, 1);
  early.put<std::uint16_t>({7, 9, 8})
      .put<std::uint8_t>({0, 10, 15})
      .put<std::uint16_t>({4, 1, 4, 16});
  early.put<std::uint8_t>({2, 3, 4});
  EXPECT_EQ(decode(info, given, early.bytes).error().code, ErrorCode::kTruncated);
  Written surplus = header(4, 3, 4, 4, 1);
  surplus.put<std::uint16_t>({7, 9, 8, 8})
      .put<std::uint8_t>({0, 10, 15})
      .put<std::uint16_t>({4, 1, 4, 16});
  surplus.put<std::uint8_t>({2, 3, 4, 3});
  EXPECT_EQ(decode(info, given, surplus.bytes).error().code, ErrorCode::kMalformed);
}

TEST(Compresso, DecodesBoundariesOfOtherEncoders) {
  // Every voxel boundary although all labels are equal: wasteful, but an answer.
  const Volume volume = volume_of<std::uint16_t>({2, 2, 1}, VoxelType::kU16, {5, 5, 5, 5});
  Written written = header(0, 1, 5, 1, 1);
  written.put<std::uint8_t>({15}).put<std::uint16_t>({12, 12, 6, 5, 12}).put<std::uint8_t>({0});

  const auto decoded = decode(volume.info(), parameters({"window=2,2,1"}), written.bytes);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(std::memcmp(decoded->data(), volume.data(), 8), 0);
}

}  // namespace
}  // namespace cvr::codecs
