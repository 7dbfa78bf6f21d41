// The parts of csgvr-c: prefix codes, the two codes of blocks and their tables, groups of bricks
// that are hard or wrong.
#include "codecs/csgvr/block_code.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <numeric>
#include <random>

#include "codecs/container.hpp"
#include "codecs/csgvr/group_reader.hpp"
#include "codecs/entropy/prefix_code.hpp"
#include "codecs/registry.hpp"
#include "codecs/succinct/bit_vector.hpp"

namespace cvr {
namespace {

using codecs::csgvr::BlockCode;
using codecs::csgvr::BlockOperations;
using codecs::csgvr::BlockShape;
using codecs::csgvr::CodedBlock;
using codecs::csgvr::KeyCounts;
using codecs::csgvr::PatternCounts;
using volumes::Coordinate;
using volumes::Extent;
using volumes::Volume;

std::uint64_t cost(std::span<const std::uint64_t> counts, std::span<const std::uint8_t> lengths) {
  return std::inner_product(counts.begin(), counts.end(), lengths.begin(), std::uint64_t{0});
}

/// The least cost of any complete code of n symbols of these counts (descending) within `limit`, by
/// trying all.
std::uint64_t least_cost(std::span<const std::uint64_t> counts, unsigned limit) {
  std::vector<std::uint8_t> lengths(counts.size(), 1);
  std::uint64_t best = ~std::uint64_t{0};
  for (;;) {
    if (codecs::entropy::is_complete_prefix_code(lengths))
      best = std::min(best, cost(counts, lengths));
    std::size_t i = 0;
    while (i < lengths.size() && lengths[i] == limit) lengths[i++] = 1;
    if (i == lengths.size()) return best;
    ++lengths[i];
  }
}

TEST(PrefixCode, IsTheShortestWithinItsLimit) {
  std::mt19937 random(1);
  for (unsigned n = 2; n <= 6; ++n) {
    for (unsigned limit = 3; limit <= 5; ++limit) {
      std::vector<std::uint64_t> counts(n);
      for (std::uint64_t& count : counts)
        count = 1 + random() % 4 * (random() % 100) * (random() % 100);
      const auto lengths = codecs::entropy::prefix_code_lengths(counts, limit);
      EXPECT_TRUE(codecs::entropy::is_complete_prefix_code(lengths));
      EXPECT_LE(std::ranges::max(lengths), limit);
      EXPECT_EQ(cost(counts, lengths), least_cost(counts, limit))
          << n << " symbols, limit " << limit;
    }
  }
}

TEST(PrefixCode, NoCodeBeginsWithAnother) {
  std::mt19937 random(2);
  std::vector<std::uint64_t> counts(300);
  for (std::uint64_t& count : counts)
    count = 1 + (random() % 1000) * (random() % 1000) * (random() % 1000);
  const auto lengths = codecs::entropy::prefix_code_lengths(counts, 13);
  const auto codes = codecs::entropy::prefix_codes(lengths);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    EXPECT_EQ(codes[i] >> lengths[i], 0u);
    for (std::size_t k = 0; k < i; ++k) {
      const unsigned shared = std::min(lengths[i], lengths[k]);
      EXPECT_NE(codes[i] & ((1u << shared) - 1), codes[k] & ((1u << shared) - 1))
          << i << " and " << k;
    }
  }
  std::vector<std::uint8_t> longer = lengths;
  ++longer[7];
  EXPECT_FALSE(codecs::entropy::is_complete_prefix_code(longer));
}

/// Shapes such as blocks have: some common, many rare, all kinds of labels of their own.
std::vector<BlockShape> shapes(std::size_t count) {
  std::mt19937 random(3);
  std::vector<BlockShape> all;
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned common = i % 3 != 0 ? 0x0f0f0f0f & random() & random() & random() : random();
    const std::array<unsigned, 3> axes{common & 0xff, common >> 8 & 0xff, common >> 16 & 0xff};
    const unsigned own =
        random() & 0xff & ~(axes[0] | axes[1] | axes[2]) & (i % 5 == 0 ? 0xff : 0x11);
    const unsigned after_first = own & (own - 1);
    all.emplace_back(axes, own, after_first & random());
  }
  return all;
}

BlockOperations widest(const BlockShape& shape) { return shape.operations(shape.widest_first()); }

BlockCode fitted(std::span<const BlockShape> fine, std::span<const BlockShape> coarse) {
  PatternCounts counts;
  for (const BlockShape& shape : coarse) counts[0].note(widest(shape));
  for (const BlockShape& shape : fine) counts[1].note(widest(shape));
  return BlockCode(counts);
}

volumes::Buffer written(const BlockCode& code) {
  codecs::ByteWriter out;
  code.write(out);
  return out.take();
}

/// Blocks written one after the other are what the shader text reads, one by one and past the
/// others.
void expect_read_back(const BlockCode& code, std::span<const BlockShape> blocks, bool fine) {
  codecs::succinct::BitAppender bits;
  std::vector<CodedBlock> coded;
  for (const BlockShape& shape : blocks) {
    coded.push_back(code.coded(widest(shape), fine));
    bits.append(coded.back().bits, coded.back().length);
  }
  std::vector<std::uint32_t> words;
  codecs::succinct::append_words(bits.words(), words);
  words.insert(words.end(), 2, 0);
  const shaders::Words stream{words.data()}, tables{code.tables().data()};
  std::uint32_t at = 0;
  std::uint32_t labels = 0;
  for (std::uint32_t i = 0; i < coded.size(); ++i) {
    std::uint32_t skipped = 0;
    ASSERT_EQ(
        cvr_c_skip(stream, tables, fine, i % 50, skipped), i % 50 == 0 ? 0 : [&] {
          std::uint32_t sum = 0;
          for (std::uint32_t k = 0; k < i % 50; ++k)
            sum += shaders::cvr_popcount32(shaders::cvr_c_own_labels(coded[k].operations));
          return sum;
        }());
    ASSERT_EQ(cvr_c_operations(stream, tables, fine, at), coded[i].operations) << "block " << i;
    labels += shaders::cvr_popcount32(shaders::cvr_c_own_labels(coded[i].operations));
    std::uint32_t past = 0;
    ASSERT_EQ(cvr_c_skip(stream, tables, fine, i + 1, past), labels);
    ASSERT_EQ(past, at) << "block " << i;
  }
  EXPECT_EQ(at, bits.size());
}

TEST(BlockCode, ReadsWhatItWrites) {
  const auto common = shapes(600);
  const BlockCode code = fitted(common, std::span(common).first(100));
  expect_read_back(code, common, true);
  expect_read_back(code, common, false);  // many of them by escapes
  const volumes::Buffer bytes = written(code);
  codecs::ByteReader in(bytes.bytes());
  const auto again = BlockCode::read(in);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->tables(), code.tables());
}

TEST(KeyCounts, NumberKeysAloneOrManyAtOnce) {
  std::mt19937 random(4);
  std::vector<std::uint64_t> keys(20000);
  for (std::uint64_t& key : keys) key = random() % 5000 * 0x100000001u;
  KeyCounts alone, together;
  std::vector<std::uint32_t> expected, numbers;
  for (const std::uint64_t key : keys) expected.push_back(alone.note(key));
  for (std::size_t i = 0; i < keys.size(); i += 700)
    together.note(std::span(keys).subspan(i, std::min<std::size_t>(700, keys.size() - i)), numbers);
  EXPECT_EQ(numbers, expected);
  for (std::size_t i = 0; i < keys.size(); i += 97) {
    ASSERT_EQ(together.count(keys[i]),
              static_cast<std::uint64_t>(std::ranges::count(keys, keys[i])));
  }
  EXPECT_EQ(together.count(1), 0u);
}

TEST(BlockCode, OfNothingHasEscapesAlone) {
  const BlockCode code = fitted({}, {});
  expect_read_back(code, shapes(100), true);
}

TEST(BlockCode, NamesTheNeighbourThatIsMostFrequent) {
  // Many blocks whose lower half can only be a copy along y; one where it could be along x too.
  const BlockShape only_y({0, 0x0f, 0}, 0, 0);
  KeyCounts counts;
  counts.note(widest(only_y), 1000);
  const BlockOperations along_y = 2u | 2u << 3 | 2u << 6 | 2u << 9;
  EXPECT_EQ(codecs::csgvr::most_frequent(BlockShape({0x0f, 0x0f, 0}, 0, 0), counts), along_y);
  EXPECT_EQ(codecs::csgvr::most_frequent(BlockShape({0x0f, 0x0f, 0}, 0, 0), {}), along_y / 2)
      << "x where nothing is known";
  EXPECT_EQ(fitted(std::vector<BlockShape>(1000, only_y), {}).coded(along_y, true).length, 1u);
}

TEST(BlockCode, RefusesTablesThatNoEncoderWrites) {
  const BlockCode code = fitted(shapes(300), shapes(40));
  const volumes::Buffer good = written(code);
  const auto refused = [](std::span<const std::byte> bytes) {
    codecs::ByteReader in(bytes);
    return !BlockCode::read(in).has_value();
  };
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_TRUE(refused(good.bytes().first(size))) << size << " bytes";
  volumes::Buffer longer;
  longer.append(good.data(), good.size());
  longer.append("\0", 1);
  EXPECT_TRUE(refused(longer.bytes()));
  // A wrong bit makes another code or none, but never one that is incomplete: every entry of the
  // lookup has a length.
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    volumes::Buffer wrong;
    wrong.append(good.data(), good.size());
    wrong.data()[bit / 8] ^= std::byte{1} << (bit % 8);
    codecs::ByteReader in(wrong.bytes());
    const auto other = BlockCode::read(in);
    if (!other) continue;
    const shaders::Words tables{other->tables().data()};
    for (std::uint32_t i = 0; i < 2 * CVR_C_LOOKUP; ++i) {
      ASSERT_NE(cvr_c_short(tables, 0, i) & 63u, 0u) << "bit " << bit;
      const std::uint32_t place = cvr_c_short(tables, CVR_C_PLACES, i);
      ASSERT_TRUE(place == CVR_C_NO_PLACE || CVR_C_OPERATIONS + place < other->tables().size())
          << "bit " << bit;
    }
  }
}

Volume made(const Extent& extent, volumes::VoxelType type,
            const std::function<std::uint64_t(const Coordinate&)>& label) {
  volumes::VolumeInfo info;
  info.extent = extent;
  info.type = type;
  Volume volume(info);
  for (std::uint64_t i = 0; i < extent.voxels(); ++i) {
    const Coordinate c = extent.coordinate(i);
    const std::uint64_t value = label(c);
    std::memcpy(volume.data() + i * size_of(type), &value, size_of(type));
  }
  return volume;
}

/// Every node at every level by single access equals the decoded level, and the finest level the
/// original.
void expect_exact(const Volume& volume, int side) {
  SCOPED_TRACE("bricks of " + std::to_string(side));
  const codecs::Codec& codec = *codecs::find_codec("csgvr-c");
  const std::vector<std::string> set{"brick=" + std::to_string(side)};
  const auto encoded = codecs::encode(codec, volumes::MemorySource(volume),
                                      *codecs::Parameters::parse(codec.parameters(), set), 1);
  ASSERT_TRUE(encoded) << encoded.error().message;
  const auto file = codecs::open_file(encoded->bytes.bytes());
  const auto decoder = codecs::open_decoder(*file);
  ASSERT_TRUE(decoder) << decoder.error().message;
  for (unsigned lod = 0; lod < (*decoder)->levels(); ++lod) {
    volumes::VolumeSink sink(codecs::level_info(volume.info(), lod));
    ASSERT_TRUE((*decoder)->decode(lod, 1, sink));
    const Volume level = sink.take();
    std::vector<Coordinate> points;
    for (std::uint64_t i = 0; i < level.extent().voxels(); ++i) {
      const Extent& e = level.extent();
      points.push_back({i % e.x << lod, i / e.x % e.y << lod, i / e.x / e.y << lod});
    }
    std::vector<std::uint64_t> labels(points.size());
    ASSERT_TRUE((*decoder)->voxel_access()->at(points, lod, labels));
    std::uint64_t wrong = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Coordinate at{points[i].x >> lod, points[i].y >> lod, points[i].z >> lod};
      wrong += labels[i] != level.label(at) || (lod == 0 && labels[i] != volume.label(at)) ? 1 : 0;
    }
    EXPECT_EQ(wrong, 0u) << "level of detail " << lod;
  }
}

TEST(Csgvrc, KeepsHardVolumes) {
  for (const int side : {16, 32, 64}) {
    expect_exact(made({64, 64, 64}, volumes::VoxelType::kU32,
                      [](const Coordinate& c) { return c.x + 64 * (c.y + 64 * c.z); }),
                 side);
    expect_exact(made({1, 1, 1}, volumes::VoxelType::kU8, [](const Coordinate&) { return 200; }),
                 side);
    expect_exact(made({70, 3, 65}, volumes::VoxelType::kU16,
                      [](const Coordinate& c) { return (c.x + c.y + c.z) % 2; }),
                 side);
    expect_exact(
        made({64, 64, 64}, volumes::VoxelType::kU32, [](const Coordinate&) { return 0xffffffff; }),
        side);
    // Constant octants, each with a label of its own: open nodes without open children.
    expect_exact(made({128, 64, 64}, volumes::VoxelType::kU8,
                      [](const Coordinate& c) { return c.x / 8 + c.y / 8 * 16 + c.z / 32; }),
                 side);
    expect_exact(made({40, 33, 17}, volumes::VoxelType::kU64,
                      [](const Coordinate& c) {
                        return (c.x / 5 + c.y / 3) << 40 | (c.z % 3 == 0 ? 0 : c.x);
                      }),
                 side);
  }
}

/// Any wrong bit of a payload is refused on opening, or every query ends within the payload (and
/// the sanitisers see that).
TEST(Csgvrc, RefusesOrSurvivesEveryWrongBit) {
  const Volume volume = made({20, 37, 18}, volumes::VoxelType::kU8, [](const Coordinate& c) {
    return c.x / 7 * 3 + c.y / 9 + (c.x * c.y * c.z % 11 == 0 ? 50 : 0);
  });
  const codecs::Codec& codec = *codecs::find_codec("csgvr-c");
  const std::vector<std::string> set{"brick=16"};
  const auto parameters = *codecs::Parameters::parse(codec.parameters(), set);
  const codecs::Payload payload =
      codec.encode(volumes::MemorySource(volume), parameters, 1).value();
  std::vector<Coordinate> points;
  for (std::uint64_t i = 0; i < volume.extent().voxels(); i += 7)
    points.push_back({i % 20, i / 20 % 37, i / 740});
  std::vector<std::uint64_t> labels(points.size());
  std::size_t refused = 0;
  const std::size_t size = payload.bytes.size();
  for (std::size_t bit = 0; bit < 8 * size; ++bit) {
    volumes::Buffer wrong;
    wrong.append(payload.bytes.data(), size);
    wrong.data()[bit / 8] ^= std::byte{1} << (bit % 8);
    const auto decoder = codec.open({volume.info(), parameters, wrong.bytes()});
    if (!decoder) {
      EXPECT_FALSE(decoder.error().message.empty());
      ++refused;
      continue;
    }
    for (unsigned lod = 0; lod < (*decoder)->levels(); lod += 2) {
      static_cast<void>((*decoder)->voxel_access()->at(points, lod, labels));
      volumes::VolumeSink sink(codecs::level_info(volume.info(), lod));
      static_cast<void>((*decoder)->decode(lod, 1, sink));
    }
  }
  EXPECT_GT(refused, 4 * size);  // half of all bits
}

}  // namespace
}  // namespace cvr
