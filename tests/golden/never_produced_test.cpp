// Payloads of the CSGV families that no encoder of this project writes: some are legal and must
// decode, all others must be refused by open() or by decoding, never believed. Written by hand from
// codecs/csgv/FORMAT.md; bricks of 16, five levels.
#include <gtest/gtest.h>

#include <cstring>

#include "codecs/bytes.hpp"
#include "codecs/registry.hpp"
#include "codecs/succinct/bit_vector.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::golden {
namespace {

using codecs::ErrorCode;
using codecs::Expected;
using codecs::Stream;
using volumes::Buffer;
using volumes::Volume;
using volumes::VolumeInfo;
using volumes::VoxelType;

using Words = std::vector<std::uint32_t>;

constexpr std::uint32_t kLevels = 5;
const VolumeInfo kBrickInfo{.extent = {16, 16, 16}, .type = VoxelType::kU32, .voxel_unit = {}};

/// A brick of csgv-nibble: level starts (decoders do not rely on them), palette size, operations,
/// palette.
Words nibble_brick(const std::vector<unsigned>& symbols, const Words& palette) {
  Words words(kLevels, 0);
  words.push_back(static_cast<std::uint32_t>(palette.size()));
  const std::size_t operations_at = words.size();
  words.resize(operations_at + (symbols.size() + 7) / 8);
  for (std::size_t i = 0; i < symbols.size(); ++i)
    words[operations_at + i / 8] |= symbols[i] << (4 * (i % 8));
  words.insert(words.end(), palette.rbegin(), palette.rend());
  return words;
}

Buffer payload(const std::vector<Words>& bricks, const std::vector<std::uint64_t>& remap = {}) {
  codecs::ByteWriter out;
  out.put(std::uint64_t{remap.size()});
  for (const std::uint64_t label : remap) out.put(label);
  out.put(std::uint64_t{0});  // no tables
  std::uint32_t start = 0;
  out.put(start);
  for (const Words& brick : bricks) out.put(start += static_cast<std::uint32_t>(brick.size()));
  for (const Words& brick : bricks) out.append(std::as_bytes(std::span(brick)));
  return out.take();
}

/// All levels decoded; the finest is returned.
Expected<Volume> decode(std::string_view id, const std::vector<std::string>& more,
                        const VolumeInfo& info, const Buffer& bytes) {
  const codecs::Codec& codec = *codecs::find_codec(id);
  std::vector<std::string> assignments = more;
  assignments.push_back("brick=16");
  const Stream stream{info, codecs::Parameters::parse(codec.parameters(), assignments).value(),
                      bytes.bytes()};
  const auto decoder = codec.open(stream);
  if (!decoder) return tl::unexpected(decoder.error());
  for (unsigned lod = (*decoder)->levels(); lod-- > 0;) {
    volumes::VolumeSink sink(codecs::level_info(info, lod));
    if (const auto ok = (*decoder)->decode(lod, 1, sink); !ok) return tl::unexpected(ok.error());
    if (lod == 0) return sink.take();
  }
  return codecs::fail(ErrorCode::kMalformed, "no levels");
}

Expected<Volume> decode_nibbles(const std::vector<unsigned>& symbols, const Words& palette,
                                bool delta = false) {
  return decode("csgv-nibble", {delta ? "delta=1" : "delta=0"}, kBrickInfo,
                payload({nibble_brick(symbols, palette)}));
}

void expect_constant(const Expected<Volume>& volume, std::uint32_t label) {
  ASSERT_TRUE(volume) << volume.error().message;
  for (const std::uint32_t voxel : volume->voxels<std::uint32_t>()) ASSERT_EQ(voxel, label);
}

void expect_refused(const Expected<Volume>& volume, const std::string& part_of_message) {
  ASSERT_FALSE(volume) << "expected: " << part_of_message;
  EXPECT_TRUE(volume.error().code == ErrorCode::kMalformed ||
              volume.error().code == ErrorCode::kTruncated);
  EXPECT_NE(volume.error().message.find(part_of_message), std::string::npos)
      << volume.error().message;
}

std::vector<unsigned> root_and_children(unsigned child, unsigned root = 4) {
  std::vector<unsigned> symbols(9, child);
  symbols[0] = root;
  return symbols;
}

TEST(NeverProducedNibbles, LegalOnesDecode) {
  expect_constant(decode_nibbles({4 + 8}, {5}), 5);
  expect_constant(decode_nibbles(root_and_children(0 + 8), {5}),
                  5);  // stop bits one level too late
  expect_constant(decode_nibbles(root_and_children(5 + 8), {5}), 5);  // "last" where "parent" fits
  expect_constant(decode_nibbles(root_and_children(4 + 8), Words(9, 5)),
                  5);  // a label nine times in the palette
  expect_constant(decode_nibbles(
                      [] {
                        std::vector<unsigned> symbols(4681, 0);  // no stop bits at all
                        symbols[0] = 4;
                        return symbols;
                      }(),
                      {5}),
                  5);
  // Advance to 6, back to 5 by a distance of one, and parents.
  const auto delta = decode_nibbles({4, 4 + 8, 6 + 8, 0, 8, 8, 8, 8, 8, 8}, {5, 6}, true);
  ASSERT_TRUE(delta) << delta.error().message;
  EXPECT_EQ(delta->label({7, 7, 7}), 6u);
  EXPECT_EQ(delta->label({8, 0, 0}), 5u);
}

TEST(NeverProducedNibbles, IllegalOperationsAreRefused) {
  expect_refused(decode_nibbles({0 + 8}, {5}), "first operation");
  for (const unsigned neighbour : {1u, 2u, 3u}) {
    expect_refused(decode_nibbles(root_and_children(neighbour + 8), {5}), "leaves the brick");
  }
  expect_refused(decode_nibbles(root_and_children(7 + 8), {5}), "unknown operation");
  expect_refused(decode_nibbles(root_and_children(6 + 8), {5, 6}), "palette distance");
  expect_refused(decode_nibbles({4}, {5}), "end early");
  expect_refused(decode_nibbles(root_and_children(4 + 8), {5, 6}), "more palette operations");
  expect_refused(decode_nibbles({4 + 8}, {}), "palette is empty");
}

TEST(NeverProducedNibbles, IllegalDistancesAreRefused) {
  expect_refused(decode_nibbles({4, 6 + 8, 0, 8, 8, 8, 8, 8, 8, 8}, {5, 6}, true),
                 "palette distance");
  // Leading zero digits say nothing and can be had for almost no bytes under rANS: a decoder would
  // count them for minutes.
  expect_refused(decode_nibbles({4, 4 + 8, 6 + 8, 8, 0, 8, 8, 8, 8, 8, 8}, {5, 6}, true),
                 "end early");
  std::vector<unsigned> endless(4000, 15);
  endless[0] = 4;
  endless[1] = 6;
  expect_refused(decode_nibbles(endless, {5, 6}, true), "end early");
}

TEST(NeverProducedNibbles, IllegalFramesAreRefused) {
  const auto open = [](const Buffer& bytes, VoxelType type = VoxelType::kU32) {
    VolumeInfo info = kBrickInfo;
    info.type = type;
    return decode("csgv-nibble", {}, info, bytes);
  };
  const Words brick = nibble_brick({4 + 8}, {5});
  Words long_palette = brick;
  long_palette[kLevels] = 0xffffffffu;
  expect_refused(open(payload({long_palette})), "longer than the brick");
  expect_refused(open(payload({Words(kLevels, 0)})), "shorter than its header");
  expect_refused(open(payload({})), "ends within the start table");
  expect_refused(open(payload({brick, brick})), "do not fill");
  expect_refused(open(payload({brick}, {77})), "u64 alone");
  expect_refused(open(payload({brick}, {77}), VoxelType::kU64), "leaves the remap table");
  const auto remapped =
      open(payload({nibble_brick({4 + 8}, {1})}, {77, ~std::uint64_t{0}}), VoxelType::kU64);
  ASSERT_TRUE(remapped) << remapped.error().message;
  EXPECT_EQ(remapped->label({3, 2, 1}), ~std::uint64_t{0});

  // Start tables: not from 0, descending, beyond the words; tables of labels and frequencies longer
  // than the payload.
  const Buffer good = payload({brick});
  const auto changed = [&](std::size_t at, std::uint32_t value) {
    Buffer bytes = good;
    std::memcpy(bytes.data() + at, &value, sizeof value);
    return open(bytes);
  };
  expect_refused(changed(16, 1), "do not fill");
  expect_refused(changed(16, 0xffffffffu), "begins at word");
  expect_refused(changed(20, 0xffffffffu), "begins at word");
  expect_refused(changed(0, 0xffffffffu), "label table");
  expect_refused(changed(4, 0x20000000u), "label table");  // 2^61 labels: their bytes overflow to 0
  expect_refused(changed(8, 0xffffffffu), "frequency tables");
  for (std::size_t size = 0; size < good.size(); ++size) {
    Buffer shorter;
    shorter.append(good.bytes().first(size));
    EXPECT_FALSE(open(shorter)) << size;
  }
}

/// The encoding of a volume by a codec with bricks of 16, and where its bricks begin.
Buffer encoded(std::string_view id, const Volume& volume) {
  const codecs::Codec& codec = *codecs::find_codec(id);
  const std::vector<std::string> assignments{"brick=16"};
  const auto parameters = codecs::Parameters::parse(codec.parameters(), assignments).value();
  return codec.encode(volumes::MemorySource(volume), parameters, 1).value().bytes;
}

TEST(NeverProducedWaveletMatrices, EveryChangedWordOfAConstantBrickIsRefused) {
  const Volume volume = samples::make_labels(kBrickInfo, [](auto&) { return 5; });
  const Buffer good = encoded("csgvr-sb", volume);
  expect_constant(decode("csgvr-sb", {}, kBrickInfo, good), 5);
  constexpr std::size_t kBrickAt = 24;
  ASSERT_EQ(good.size(), kBrickAt + 4 * 26);
  // All but the last word, which is the label itself. 73: the 64-bit words of the stop bits of a
  // whole brick.
  for (std::size_t word = 0; word < 25; ++word) {
    for (const std::uint32_t value : {0u, 1u, 2u, 3u, 7u, 64u, 73u, 0x7fffffffu, 0xffffffffu}) {
      Buffer bytes = good;
      std::uint32_t before = 0;
      std::memcpy(&before, bytes.data() + kBrickAt + 4 * word, 4);
      if (before == value) continue;
      std::memcpy(bytes.data() + kBrickAt + 4 * word, &value, 4);
      EXPECT_FALSE(decode("csgvr-sb", {}, kBrickInfo, bytes)) << "word " << word << " = " << value;
    }
  }
}

TEST(NeverProducedWaveletMatrices, StopBitsOfTheFinestLevelAreNotRead) {
  const Volume volume = samples::make_labels(
      kBrickInfo, [](const auto& c) { return samples::random_at(1, c.x / 3 + 9 * c.y) % 5; });
  Buffer bytes = encoded("csgvr-sb", volume);
  auto* words = reinterpret_cast<std::uint32_t*>(bytes.data() + 24);
  const std::size_t count = (bytes.size() - 24) / 4;
  const std::size_t s_words_at = count - 1 - words[kLevels];
  const std::uint32_t symbols = words[kLevels + 2 + 5];
  ASSERT_EQ(words[s_words_at], (symbols + 63) / 64);
  const std::size_t s_at = s_words_at - 2 * words[s_words_at];
  for (std::uint32_t i = words[kLevels - 1]; i < symbols; ++i)
    words[s_at + i / 32] |= 1u << (i % 32);
  std::vector<std::uint64_t> stop_bits(words[s_words_at]);
  std::memcpy(stop_bits.data(), words + s_at, 8 * stop_bits.size());
  Words rank;
  codecs::succinct::append_flat_rank(stop_bits, symbols, rank);
  std::memcpy(words + s_at - rank.size(), rank.data(), 4 * rank.size());
  const auto decoded = decode("csgvr-sb", {}, kBrickInfo, bytes);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(std::memcmp(decoded->data(), volume.data(), kBrickInfo.bytes()), 0);
}

TEST(NeverProducedRans, IllegalTablesAndStreamsAreRefused) {
  const Volume volume =
      samples::make_labels(kBrickInfo, [](const auto& c) { return (c.x + c.y + c.z) / 3; });
  const Buffer good = encoded("csgv-rans", volume);
  ASSERT_TRUE(decode("csgv-rans", {}, kBrickInfo, good));
  const auto changed = [&](std::size_t at, std::uint16_t value) {
    Buffer bytes = good;
    std::memcpy(bytes.data() + at, &value, sizeof value);
    return decode("csgv-rans", {}, kBrickInfo, bytes);
  };
  expect_refused(changed(16, 0xffff), "frequenc");                     // the sum
  expect_refused(changed(8, 60), "frequenc");                          // the tables' size
  expect_refused(changed(80 + 8 + 4 * 4 + 2, 0xffff), "fine stream");  // its start
  Buffer shorter;  // the coarse stream loses its bytes to the palette
  shorter.append(good.bytes());
  std::uint32_t palette_size = 0;
  std::memcpy(&palette_size, shorter.data() + 88 + 4 * kLevels, 4);
  palette_size = static_cast<std::uint32_t>((good.size() - 88) / 4 - kLevels - 1);
  std::memcpy(shorter.data() + 88 + 4 * kLevels, &palette_size, 4);
  EXPECT_FALSE(decode("csgv-rans", {}, kBrickInfo, shorter));
}

}  // namespace
}  // namespace cvr::golden
