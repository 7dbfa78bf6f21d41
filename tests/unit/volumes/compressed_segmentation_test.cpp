#include "volumes/compressed_segmentation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "tests/samples/small_labels.hpp"

namespace cvr::volumes {
namespace {

using test::Content;
using test::kContents;
using test::kExtents;
using test::kLabelTypes;
using test::sample_volume;
using testing::ElementsAre;

constexpr BlockSize kBlocks[] = {{8, 8, 8}, {1, 1, 1},  {8, 2, 3},
                                 {3, 5, 2}, {16, 4, 1}, {64, 64, 2}};

TEST(CompressedSegmentation, WordsOfAUniformAndAMixedBlock) {
  // Block 0 holds 7 5 / 5 5: table {5, 7}, one bit a value, only voxel 0 has index 1. Block 1 holds
  // 9 only; its second column lies outside.
  const std::uint32_t labels[] = {7, 5, 9, 5, 5, 9};
  const auto words = encode_compressed_segmentation(labels, {3, 2, 1}, {2, 2, 1});
  ASSERT_TRUE(words);
  EXPECT_THAT(*words,
              ElementsAre(1, 0x01000005u, 4, 7, 7, /*values*/ 1, /*table*/ 5, 7, /*table*/ 9));
}

TEST(CompressedSegmentation, WordsOfASharedTableOfU64) {
  const std::uint64_t high = ~std::uint64_t{0};
  const std::uint64_t labels[] = {high, 3, 3, high};
  const auto words = encode_compressed_segmentation(labels, {4, 1, 1}, {2, 1, 1});
  ASSERT_TRUE(words);
  EXPECT_THAT(*words, ElementsAre(1, 0x01000005u, 4, 0x01000005u, 9, /*values*/ 1,
                                  /*table*/ 3, 0, 0xffffffffu, 0xffffffffu, /*values*/ 2));
}

TEST(CompressedSegmentation, WordsOfFourBitValuesWithPadding) {
  // Eight labels take four bits (three do not exist); the second row of the block lies outside and
  // has index 0.
  const std::uint8_t labels[] = {70, 60, 50, 40, 30, 20, 10, 0};
  const auto words = encode_compressed_segmentation(labels, {8, 1, 1}, {8, 2, 1});
  ASSERT_TRUE(words);
  EXPECT_THAT(*words, ElementsAre(1, 0x04000004u, 2, /*values*/ 0x01234567u, 0, /*table*/ 0, 10, 20,
                                  30, 40, 50, 60, 70));
}

TEST(CompressedSegmentation, RoundTripsAllTypesExtentsAndBlocks) {
  for (const BlockSize& block : kBlocks) {
    for (const Extent& extent : kExtents) {
      for (const VoxelType type : kLabelTypes) {
        for (const Content content : kContents) {
          const Volume volume = sample_volume(content, extent, type);
          with_label_type(type, [&]<class T>() {
            const auto words =
                encode_compressed_segmentation<T>(volume.voxels<T>().data(), extent, block);
            ASSERT_TRUE(words) << words.error().message;
            std::vector<T> decoded(extent.voxels());
            const auto ok =
                decode_compressed_segmentation<T>(*words, extent, block, decoded.data());
            ASSERT_TRUE(ok) << ok.error().message;
            ASSERT_EQ(std::memcmp(decoded.data(), volume.data(), volume.info().bytes()), 0)
                << test::describe(content, volume.info()) << ", block " << block.x << "," << block.y
                << "," << block.z;
            const auto stream = CompressedSegmentation::open(*words, extent, block, kTableWords<T>);
            ASSERT_TRUE(stream);
            const auto sums = count_words(*words, extent, block);
            EXPECT_EQ(sums.headers + sums.values + sums.tables, words->size());
            for (std::uint64_t i = 0; i < extent.voxels(); i += 7) {
              const Coordinate c = extent.coordinate(i);
              ASSERT_EQ(stream->label(c), volume.label(c));
            }
          });
        }
      }
    }
  }
}

TEST(CompressedSegmentation, NarrowLabelsGiveTheWordsOfU32) {
  const Extent extent{21, 18, 11};
  const Volume narrow = sample_volume(Content::kCells, extent, VoxelType::kU8);
  std::vector<std::uint32_t> wide(narrow.voxels<std::uint8_t>().begin(),
                                  narrow.voxels<std::uint8_t>().end());
  EXPECT_EQ(
      encode_compressed_segmentation(narrow.voxels<std::uint8_t>().data(), extent, {}).value(),
      encode_compressed_segmentation(wide.data(), extent, {}).value());
}

TEST(CompressedSegmentation, EncodesAndDecodesABoxInsideALargerArray) {
  const Extent whole{30, 20, 12}, part{17, 9, 10};
  const Coordinate origin{5, 4, 1};
  const Volume volume = sample_volume(Content::kCells, whole, VoxelType::kU32);
  const std::uint64_t at = whole.index(origin);
  const LabelBox<const std::uint32_t> box{volume.voxels<std::uint32_t>().data() + at, part, whole.x,
                                          whole.x * whole.y};
  std::vector<std::uint32_t> dense;
  for (std::uint64_t z = 0; z < part.z; ++z) {
    for (std::uint64_t y = 0; y < part.y; ++y) {
      for (std::uint64_t x = 0; x < part.x; ++x)
        dense.push_back(box.labels[x + whole.x * (y + whole.y * z)]);
    }
  }
  const auto words = encode_compressed_segmentation(box, BlockSize{});
  ASSERT_TRUE(words);
  EXPECT_EQ(*words, encode_compressed_segmentation(dense.data(), part, BlockSize{}).value());

  std::vector<std::uint32_t> target(whole.voxels(), 77);
  const LabelBox<std::uint32_t> out{target.data() + at, part, whole.x, whole.x * whole.y};
  ASSERT_TRUE(decode_compressed_segmentation(*words, out, BlockSize{}));
  for (std::uint64_t i = 0; i < whole.voxels(); ++i) {
    const Coordinate c{i % whole.x - origin.x, i / whole.x % whole.y - origin.y,
                       i / whole.x / whole.y - origin.z};
    ASSERT_EQ(target[i], part.contains(c) ? volume.voxels<std::uint32_t>()[i] : 77u);
  }
}

TEST(CompressedSegmentation, RefusesTablesBeyond24Bits) {
  // Blocks of one voxel: two header words each; 2^23 blocks put the first table at 2^24.
  const std::vector<std::uint8_t> labels(std::size_t{1} << 23);
  const auto words = encode_compressed_segmentation(labels.data(), {1u << 23, 1, 1}, {1, 1, 1});
  ASSERT_FALSE(words);
  EXPECT_EQ(words.error().code, ErrorCode::kTooLarge);
  const auto fits =
      encode_compressed_segmentation(labels.data(), {(1u << 23) - 1, 1, 1}, {1, 1, 1});
  ASSERT_TRUE(fits);
  EXPECT_EQ(fits->size(), (std::size_t{1} << 24));
}

TEST(CompressedSegmentation, RefusesTablesThatGrowBeyond24Bits) {
  // Blocks of 64 x 64 x 8, every voxel its own label: 64 Ki words of table and 16 Ki or 32 Ki of
  // values each.
  const Extent extent{512, 512, 96};
  std::vector<std::uint32_t> labels(extent.voxels());
  for (std::size_t i = 0; i < labels.size(); ++i) labels[i] = static_cast<std::uint32_t>(i);
  const auto words = encode_compressed_segmentation(labels.data(), extent, {64, 64, 8});
  ASSERT_FALSE(words);
  EXPECT_EQ(words.error().code, ErrorCode::kTooLarge);
}

// Streams that no encoder writes. The base is that of WordsOfAUniformAndAMixedBlock.
struct Malformed {
  std::vector<std::uint32_t> words;
  ErrorCode code;
};

TEST(CompressedSegmentation, RefusesMalformedStreams) {
  const std::vector<std::uint32_t> good{1, 0x01000005u, 4, 7, 7, 1, 5, 7, 9};
  const auto with = [&good](std::size_t at, std::uint32_t word) {
    auto words = good;
    words[at] = word;
    return words;
  };
  const Malformed cases[] = {
      {{}, ErrorCode::kTruncated},
      {{1, 0x01000005u, 4, 7}, ErrorCode::kTruncated},
      {with(0, 0), ErrorCode::kMalformed},            // channel offset
      {with(0, 2), ErrorCode::kMalformed},            //
      {with(1, 0x03000005u), ErrorCode::kMalformed},  // three bits per value
      {with(1, 0x40000005u), ErrorCode::kMalformed},  // 64 bits per value
      {with(1, 0xff000005u), ErrorCode::kMalformed},  //
      {with(2, 8), ErrorCode::kMalformed},            // values just behind the end
      {with(2, 0xffffffffu), ErrorCode::kMalformed},  //
      {with(1, 0x01000007u),
       ErrorCode::kMalformed},  // index 1 of a table of which only entry 0 is inside
      {with(1, 0x01ffffffu), ErrorCode::kMalformed},  // table far outside
      {with(3, 8), ErrorCode::kMalformed},            // table of one entry just behind the end
  };
  std::uint32_t labels[6];
  for (const Malformed& c : cases) {
    const auto result = decode_compressed_segmentation(c.words, {3, 2, 1}, {2, 2, 1}, labels);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, c.code) << result.error().message;
  }
  EXPECT_TRUE(decode_compressed_segmentation(good, {3, 2, 1}, {2, 2, 1}, labels));
}

TEST(CompressedSegmentation, AcceptsStreamsOfOtherEncoders) {
  // Unsorted tables, overlapping tables, values behind tables, garbage in the padding: all legal to
  // read.
  const std::vector<std::uint32_t> words{1, 0x01000004u, 6, 5,
                                         0, /*table*/ 7, 5, /*values*/ 0xfffffffeu};
  std::uint32_t labels[6];
  ASSERT_TRUE(decode_compressed_segmentation(words, {3, 2, 1}, {2, 2, 1}, labels));
  EXPECT_THAT(labels, ElementsAre(7, 5, 5, 5, 5, 5));
}

TEST(CompressedSegmentation, RefusesLabelsTooWideForTheType) {
  const std::uint32_t labels[] = {255, 256};
  const auto words = encode_compressed_segmentation(labels, {2, 1, 1}, {2, 1, 1});
  ASSERT_TRUE(words);
  std::uint8_t narrow[2];
  const auto result = decode_compressed_segmentation(*words, {2, 1, 1}, {2, 1, 1}, narrow);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kMalformed);
}

TEST(CompressedSegmentation, EveryTruncationIsAnError) {
  const Extent extent{9, 8, 5};
  const Volume volume = sample_volume(Content::kCells, extent, VoxelType::kU64);
  const auto words =
      encode_compressed_segmentation(volume.voxels<std::uint64_t>().data(), extent, {4, 4, 4});
  ASSERT_TRUE(words);
  for (std::size_t size = 0; size < words->size(); ++size) {
    // A copy of its own, so that a sanitizer sees any read behind it.
    const std::vector<std::uint32_t> part(words->begin(),
                                          words->begin() + static_cast<std::ptrdiff_t>(size));
    std::vector<std::uint64_t> decoded(extent.voxels());
    EXPECT_FALSE(decode_compressed_segmentation(part, extent, {4, 4, 4}, decoded.data())) << size;
  }
}

TEST(CompressedSegmentation, AnnouncedExtentsAllocateNothing) {
  const std::vector<std::uint32_t> words{1, 0, 0, 5};
  const std::uint64_t huge = 0xffffffffu;
  for (const Extent& extent :
       {Extent{huge, 1, 1}, Extent{huge, huge, huge}, Extent{1, huge, huge}}) {
    const auto stream = CompressedSegmentation::open(words, extent, {1, 1, 1}, 1);
    ASSERT_FALSE(stream);
    EXPECT_EQ(stream.error().code, ErrorCode::kTruncated);
  }
  EXPECT_EQ(CompressedSegmentation::open(words, {huge + 1, 1, 1}, {64, 1, 1}, 1).error().code,
            ErrorCode::kTooLarge);
}

TEST(CompressedSegmentation, RefusesBlockEdgesOutOfRange) {
  const std::uint32_t label = 0;
  for (const BlockSize& block :
       {BlockSize{0, 8, 8}, BlockSize{8, 65, 8}, BlockSize{8, 8, 0xffffffffu}}) {
    const auto words = encode_compressed_segmentation(&label, {1, 1, 1}, block);
    ASSERT_FALSE(words);
    EXPECT_EQ(words.error().code, ErrorCode::kBadArgument);
  }
}

}  // namespace
}  // namespace cvr::volumes
