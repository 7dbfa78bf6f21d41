// The codec neuroglancer: its chunk table, levels and access facets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "codecs/codec.hpp"
#include "codecs/registry.hpp"
#include "shaders/shared/shared.hpp"
#include "tests/samples/small_labels.hpp"
#include "volumes/compressed_segmentation.hpp"
#include "volumes/pyramid.hpp"

namespace cvr::codecs {
namespace {

using test::Content;
using test::sample_volume;
using testing::ElementsAre;
using volumes::MemorySource;

const Codec& codec() { return *find_codec("neuroglancer"); }
Parameters parameters(const std::vector<std::string>& assignments) {
  return Parameters::parse(codec().parameters(), assignments).value();
}
Volume labels_u32(const Extent& extent, const std::vector<std::uint32_t>& labels) {
  Volume volume({.extent = extent, .type = VoxelType::kU32, .voxel_unit = {}});
  std::memcpy(volume.data(), labels.data(), labels.size() * 4);
  return volume;
}
std::vector<std::uint32_t> words_of(const Buffer& bytes) {
  std::vector<std::uint32_t> words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), words.size() * 4);
  return words;
}

TEST(Pyramid, MostFrequentWinsAndTiesGoToTheFirstInMortonOrder) {
  // One node a case; children in Morton order.
  const std::pair<std::vector<std::uint32_t>, std::uint32_t> cases[] = {
      {{1, 2, 3, 4, 5, 6, 7, 8}, 1}, {{1, 2, 2, 4, 5, 6, 7, 8}, 2}, {{1, 2, 2, 1, 5, 6, 7, 8}, 1},
      {{9, 1, 1, 1, 9, 9, 9, 1}, 9}, {{9, 1, 1, 1, 9, 9, 1, 1}, 1}, {{3, 3, 3, 3, 3, 3, 3, 3}, 3},
      {{8, 7, 7, 6, 6, 6, 5, 5}, 6}, {{0, 1, 2, 3, 3, 2, 1, 9}, 1},
  };
  for (const auto& [children, expected] : cases) {
    const Volume volume = labels_u32({2, 2, 2}, children);
    const Volume coarse = volumes::coarser_level(MemorySource(volume), 1);
    ASSERT_EQ(coarse.extent(), (Extent{1, 1, 1}));
    EXPECT_EQ(coarse.label({0, 0, 0}), expected);
  }
}

TEST(Pyramid, ChildrenOutsideDoNotVote) {
  // 3 x 1 x 1: node 1 has the child 7 only. 1 x 3 x 1 and 1 x 1 x 3 alike.
  for (const Extent& extent : {Extent{3, 1, 1}, Extent{1, 3, 1}, Extent{1, 1, 3}}) {
    const Volume coarse = volumes::coarser_level(MemorySource(labels_u32(extent, {5, 6, 7})), 2);
    EXPECT_THAT(coarse.voxels<std::uint32_t>(), ElementsAre(5, 7));
  }
}

TEST(Pyramid, AgreesWithCountingEveryNode) {
  for (const VoxelType type : test::kLabelTypes) {
    const Volume volume = sample_volume(Content::kNoise, {37, 22, 15}, type);
    const Volume coarse = volumes::coarser_level(MemorySource(volume), 3);
    ASSERT_EQ(coarse.extent(), (Extent{19, 11, 8}));
    for (std::uint64_t i = 0; i < coarse.extent().voxels(); ++i) {
      const Coordinate node{i % 19, i / 19 % 11, i / 19 / 11};
      std::vector<std::pair<std::uint64_t, int>> votes;
      for (unsigned child = 0; child < 8; ++child) {
        const Coordinate c{2 * node.x + (child & 1), 2 * node.y + (child >> 1 & 1),
                           2 * node.z + (child >> 2)};
        if (!volume.extent().contains(c)) continue;
        const std::uint64_t label = volume.label(c);
        auto found = std::ranges::find(votes, label, &std::pair<std::uint64_t, int>::first);
        if (found == votes.end()) found = votes.insert(votes.end(), {label, 0});
        ++found->second;
      }
      const auto best = std::ranges::max_element(votes, {}, &std::pair<std::uint64_t, int>::second);
      ASSERT_EQ(coarse.label(node), best->first);
    }
  }
}

TEST(Neuroglancer, PayloadOfTwoChunksByHand) {
  // 3 x 1 x 1 in chunks of 2: [7 5] and [9].
  const Volume volume = labels_u32({3, 1, 1}, {7, 5, 9});
  const auto payload =
      codec().encode(MemorySource(volume), parameters({"block=2,1,1", "chunk=2"}), 1);
  ASSERT_TRUE(payload);
  EXPECT_THAT(words_of(payload->bytes),
              ElementsAre(2, 1,                                   // edge, levels
                          0, 0, 6, 0, 10, 0,                      // chunk table
                          1, 0x01000003u, 2, /*values*/ 1, 5, 7,  // chunk 0
                          1, 2, 2, 9));                           // chunk 1
  EXPECT_EQ(payload->published_bytes, 40u);
  EXPECT_EQ(payload->breakdown[ByteClass::kHeader], 8u + 12 + 12);
  EXPECT_EQ(payload->breakdown[ByteClass::kIndex], 24u);
  EXPECT_EQ(payload->breakdown[ByteClass::kOperations], 4u);
  EXPECT_EQ(payload->breakdown[ByteClass::kPalette], 12u);
}

TEST(Neuroglancer, StreamsArePublicStreams) {
  const Volume volume = sample_volume(Content::kCells, {70, 40, 33}, VoxelType::kU64);
  const auto payload = codec().encode(MemorySource(volume), parameters({}), 1);
  ASSERT_TRUE(payload);
  const auto words = volumes::encode_compressed_segmentation(volume.voxels<std::uint64_t>().data(),
                                                             volume.extent(), {});
  ASSERT_TRUE(words);
  const auto all = words_of(payload->bytes);
  EXPECT_TRUE(std::equal(words->begin(), words->end(), all.begin() + 6, all.end()));
  EXPECT_EQ(payload->published_bytes, words->size() * 4);
}

TEST(Neuroglancer, LevelsVoxelsAndBricksAgreeWithThePyramid) {
  for (const auto& assignments : {std::vector<std::string>{"levels=4", "chunk=16"},
                                  {"levels=3", "chunk=12", "block=5,4,3"}}) {
    for (const VoxelType type : {VoxelType::kU8, VoxelType::kU64}) {
      std::vector<Volume> levels{sample_volume(Content::kCells, {45, 30, 37}, type)};
      const auto payload = codec().encode(MemorySource(levels[0]), parameters(assignments), 2);
      ASSERT_TRUE(payload) << payload.error().message;
      const auto decoder =
          codec().open({levels[0].info(), parameters(assignments), payload->bytes.bytes()});
      ASSERT_TRUE(decoder) << decoder.error().message;
      for (unsigned lod = 0; lod < (*decoder)->levels(); ++lod) {
        if (lod > 0) levels.push_back(volumes::coarser_level(MemorySource(levels.back()), 1));
        const Volume& truth = levels.back();
        volumes::VolumeSink sink(level_info(levels[0].info(), lod));
        ASSERT_TRUE((*decoder)->decode(lod, 2, sink));
        const Volume decoded = sink.take();
        ASSERT_EQ(std::memcmp(decoded.data(), truth.data(), truth.bytes().size()), 0) << lod;

        std::vector<Coordinate> points;
        for (std::uint64_t i = 0; i < levels[0].extent().voxels(); i += 3)
          points.push_back({i % 45, i / 45 % 30, i / 45 / 30});
        std::vector<std::uint64_t> labels(points.size());
        ASSERT_TRUE((*decoder)->voxel_access()->at(points, lod, labels));
        for (std::size_t i = 0; i < points.size(); ++i) {
          ASSERT_EQ(labels[i],
                    truth.label({points[i].x >> lod, points[i].y >> lod, points[i].z >> lod}));
        }

        const BrickAccess& bricks = *(*decoder)->brick_access();
        const std::uint64_t edge = bricks.brick_size().x >> lod;
        const Extent grid = bricks.brick_grid();
        for (std::uint64_t b = 0; b < grid.voxels(); ++b) {
          const Coordinate brick = grid.coordinate(b);
          const Coordinate origin{brick.x * edge, brick.y * edge, brick.z * edge};
          const Extent size{std::min(edge, truth.extent().x - origin.x),
                            std::min(edge, truth.extent().y - origin.y),
                            std::min(edge, truth.extent().z - origin.z)};
          std::vector<std::byte> expected(size.voxels() * size_of(type)), found(expected.size());
          MemorySource(truth).read({origin, size}, expected.data());
          ASSERT_TRUE(bricks.decode_brick(brick, lod, found.data()));
          ASSERT_EQ(found, expected);
        }
      }
      std::uint64_t label = 0;
      const Coordinate point{0, 0, 0};
      EXPECT_FALSE((*decoder)->voxel_access()->at({&point, 1}, (*decoder)->levels(), {&label, 1}));
      EXPECT_FALSE((*decoder)->brick_access()->decode_brick({9, 0, 0}, 0, nullptr));
    }
  }
}

TEST(Neuroglancer, HalvesChunksThatDoNotFitAndRefusesGivenOnes) {
  // Every voxel its own label: 2 header, 256 value and 512 table words per block of 512 voxels; 2^24
  // words are 21 787 blocks.
  const Extent extent{256, 256, 200};
  Volume volume({.extent = extent, .type = VoxelType::kU32, .voxel_unit = {}});
  std::uint32_t next = 0;
  for (std::uint32_t& label : volume.voxels<std::uint32_t>()) label = next++;
  const auto refused = codec().encode(MemorySource(volume), parameters({"chunk=512"}), 1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("24 bits"));
  const auto payload = codec().encode(MemorySource(volume), parameters({}), 2);
  ASSERT_TRUE(payload) << payload.error().message;
  std::uint32_t edge = 0;
  std::memcpy(&edge, payload->bytes.data(), 4);
  EXPECT_EQ(edge, 128u);
  const auto decoder = codec().open({volume.info(), parameters({}), payload->bytes.bytes()});
  ASSERT_TRUE(decoder);
  volumes::MemorySource truth(volume);
  volumes::CompareSink compare(truth);
  ASSERT_TRUE((*decoder)->decode(0, 2, compare));
  EXPECT_EQ(compare.compared(), extent.voxels());
  EXPECT_EQ(compare.mismatches(), 0u);
}

TEST(Neuroglancer, SharedDecoderTextGivesEveryLabel) {
  const Extent extent{37, 26, 19};
  for (const volumes::BlockSize& block :
       {volumes::BlockSize{8, 8, 8}, volumes::BlockSize{5, 3, 4}, volumes::BlockSize{37, 26, 19}}) {
    for (const Content content :
         {Content::kCells, Content::kDistinct, Content::kExtremes, Content::kZero}) {
      for (const VoxelType type : {VoxelType::kU32, VoxelType::kU64}) {
        const Volume volume = sample_volume(content, extent, type);
        volumes::with_label_type(type, [&]<class T>() {
          const auto words =
              volumes::encode_compressed_segmentation<T>(volume.voxels<T>().data(), extent, block);
          ASSERT_TRUE(words);
          const auto blocks = [](std::uint64_t n, std::uint32_t edge) {
            return static_cast<std::uint32_t>((n + edge - 1) / edge);
          };
          const shaders::NeuroglancerStream stream{
              blocks(extent.x, block.x), blocks(extent.y, block.y), block.x, block.y, block.z,
              volumes::kTableWords<T>};
          for (std::uint32_t i = 0; i < extent.voxels(); ++i) {
            const std::uint32_t x = i % 37, y = i / 37 % 26, z = i / 37 / 26;
            ASSERT_EQ(shaders::cvr_neuroglancer_label({words->data()}, stream, x, y, z),
                      volume.label({x, y, z}));
          }
        });
      }
    }
  }
}

TEST(Neuroglancer, RefusesChunksThatLevelsCannotHalve) {
  const Volume volume = labels_u32({3, 1, 1}, {7, 5, 9});
  const auto refused = codec().encode(MemorySource(volume), parameters({"chunk=6", "levels=3"}), 1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBadArgument);
}

TEST(Neuroglancer, RefusesMalformedPayloads) {
  const Volume volume = labels_u32({3, 1, 1}, {7, 5, 9});
  const auto given = parameters({"block=2,1,1", "chunk=2"});
  const auto payload = codec().encode(MemorySource(volume), given, 1);
  ASSERT_TRUE(payload);
  const auto open_with = [&](std::size_t word, std::uint32_t value) {
    Buffer damaged = payload->bytes;
    std::memcpy(damaged.data() + 4 * word, &value, 4);
    return codec().open({volume.info(), given, damaged.bytes()});
  };
  ASSERT_TRUE(open_with(0, 2));
  const std::tuple<std::size_t, std::uint32_t, ErrorCode> cases[] = {
      {0, 0, ErrorCode::kMalformed},
      {0, 1, ErrorCode::kMalformed},
      {1, 2, ErrorCode::kMalformed},
      {2, 1, ErrorCode::kMalformed},
      {4, 11, ErrorCode::kMalformed},
      {4, 5, ErrorCode::kMalformed},
      {5, 1, ErrorCode::kMalformed},
      {6, 9, ErrorCode::kMalformed},
      {6, 11, ErrorCode::kTruncated},
      {8, 2, ErrorCode::kMalformed},
      {9, 0x05000003u, ErrorCode::kMalformed},
      {15, 3, ErrorCode::kMalformed},
      {15, 0x01000002u, ErrorCode::kMalformed},
  };
  for (const auto& [word, value, code] : cases) {
    const auto opened = open_with(word, value);
    ASSERT_FALSE(opened) << word;
    EXPECT_EQ(opened.error().code, code) << word << ": " << opened.error().message;
  }
}

TEST(Neuroglancer, RefusesLabelsTooWideForTheVolume) {
  const Volume volume = labels_u32({2, 1, 1}, {300, 5});
  const auto payload = codec().encode(MemorySource(volume), parameters({}), 1);
  ASSERT_TRUE(payload);
  VolumeInfo narrow = volume.info();
  narrow.type = VoxelType::kU8;
  const auto decoder = codec().open({narrow, parameters({}), payload->bytes.bytes()});
  ASSERT_TRUE(decoder);
  volumes::VolumeSink sink(narrow);
  EXPECT_FALSE((*decoder)->decode(0, 1, sink));
  std::uint64_t label = 0;
  const Coordinate first{0, 0, 0}, second{1, 0, 0};
  EXPECT_FALSE((*decoder)->voxel_access()->at({&first, 1}, 0, {&label, 1}));
  EXPECT_TRUE((*decoder)->voxel_access()->at({&second, 1}, 0, {&label, 1}));
  EXPECT_EQ(label, 5u);
}

TEST(Neuroglancer, ReadsUnalignedPayloads) {
  const Volume volume = sample_volume(Content::kCells, {20, 20, 20}, VoxelType::kU32);
  const auto payload = codec().encode(MemorySource(volume), parameters({}), 1);
  ASSERT_TRUE(payload);
  Buffer shifted;
  shifted.append("x", 1);
  shifted.append(payload->bytes.bytes());
  const auto decoder = codec().open({volume.info(), parameters({}), shifted.bytes().subspan(1)});
  ASSERT_TRUE(decoder);
  volumes::MemorySource truth(volume);
  volumes::CompareSink sink(truth);
  ASSERT_TRUE((*decoder)->decode(0, 1, sink));
  EXPECT_EQ(sink.mismatches(), 0u);
}

}  // namespace
}  // namespace cvr::codecs
