// The operations that csgv-nibble and csgv-rans write, against the naive ones.
#include <gtest/gtest.h>

#include "codecs/entropy/rans.hpp"
#include "tests/unit/codecs/csgv/encoded_bricks.hpp"

namespace cvr::naive {
namespace {

std::uint8_t nibble(std::span<const std::uint32_t> words, std::size_t i) {
  return static_cast<std::uint8_t>(words[i / 8] >> (4 * (i % 8)) & 15);
}

std::vector<std::uint32_t> reversed_tail(std::span<const std::uint32_t> words, std::size_t count) {
  return {words.rbegin(), words.rbegin() + static_cast<std::ptrdiff_t>(count)};
}

class SerialOperations : public testing::TestWithParam<std::string> {};

TEST_P(SerialOperations, NibblesAreTheNaiveOnes) {
  for (const int side : {16, 32, 64}) {
    for (const bool delta : {false, true}) {
      // The search for the distance among 262,144 entries is quadratic in the naive text.
      if (delta && GetParam().starts_with("every_voxel_its_label")) continue;
      const Bricks bricks = encode_bricks(samples::sample(GetParam()).volume(), "csgv-nibble", side,
                                          {delta ? "delta=1" : "delta=0"});
      for (std::size_t i = 0; i < bricks.grid.voxels(); ++i) {
        SCOPED_TRACE(testing::Message()
                     << "brick " << i << " of side " << side << ", delta " << delta);
        const Operations naive =
            naive_operations(bricks, i, {.stop_bits = true, .keep_outside = false, .delta = delta});
        const auto words = bricks.brick(i);
        const std::size_t levels = naive.level_starts.size();
        for (std::size_t l = 0; l < levels; ++l)
          ASSERT_EQ(words[l], naive.level_starts[l]) << "level " << l;
        ASSERT_EQ(words[levels], naive.palette.size());
        const std::size_t operation_words = (naive.symbols.size() + 7) / 8;
        ASSERT_EQ(words.size(), levels + 1 + operation_words + naive.palette.size());
        const auto operations = words.subspan(levels + 1, operation_words);
        for (std::size_t k = 0; k < 8 * operation_words; ++k) {
          const int expected = k < naive.symbols.size() ? naive.symbols[k].nibble() : 0;
          ASSERT_EQ(nibble(operations, k), expected) << "symbol " << k;
        }
        ASSERT_EQ(reversed_tail(words, naive.palette.size()), naive.palette);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Zoo, SerialOperations, testing::ValuesIn(stored_as_they_are()),
                         [](const auto& info) { return info.param; });

/// Counts of symbols in the coarse levels and in the finest.
using Counts = std::array<std::array<std::uint64_t, 16>, 2>;

void count(const Operations& operations, Counts& counts) {
  for (std::size_t k = 0; k < operations.symbols.size(); ++k) {
    ++counts[k < operations.level_starts.back() ? 0 : 1][operations.symbols[k].nibble()];
  }
}

TEST(SerialOperations, RansTablesComeFromEveryNthBrickOfEachAxis) {
  // 8 x 8 x 8 bricks: a stride of 2 leaves the 64 bricks that a pre-pass needs at least. Odd bricks
  // hold noise, even bricks cells.
  const volumes::VolumeInfo info{
      .extent = {128, 127, 126}, .type = volumes::VoxelType::kU8, .voxel_unit = {}};
  const Bricks bricks = encode_bricks(
      samples::make_labels(info,
                           [](const volumes::Coordinate& c) -> std::uint64_t {
                             const bool odd = (c.x / 16 | c.y / 16 | c.z / 16) % 2 == 1;
                             const volumes::Extent e{128, 127, 126};
                             return odd ? samples::random_at(3, e.index(c))
                                        : (c.x * 3 + c.y + c.z) / 9;
                           }),
      "csgv-rans", 16, {"sampling=2"});
  Counts counts{};
  for (std::size_t i = 0; i < bricks.grid.voxels(); ++i) {
    const auto& g = bricks.grid;
    if (i % g.x % 2 != 0 || i / g.x % g.y % 2 != 0 || i / (g.x * g.y) % 2 != 0) continue;
    count(naive_operations(bricks, i, {.stop_bits = true, .keep_outside = false, .delta = false}),
          counts);
  }
  ASSERT_EQ(bricks.tables.size(), 64u);
  for (unsigned part = 0; part < 2; ++part) {
    const auto expected =
        codecs::entropy::RansTable::fit(counts[part], part == 0 ? 0x3f3f : 0x3f).frequencies();
    for (unsigned s = 0; s < 16; ++s) {
      const int found = bricks.tables[32 * part + 2 * s] | bricks.tables[32 * part + 2 * s + 1]
                                                               << 8;
      EXPECT_EQ(found, expected[s]) << "table " << part << ", symbol " << s;
    }
  }
}

TEST(SerialOperations, RansStreamsHoldTheNaiveSymbols) {
  const Bricks bricks = encode_bricks(samples::sample("odd_sides_65x33x70_u32").volume(),
                                      "csgv-rans", 32, {"sampling=1", "delta=1"});
  std::array<codecs::entropy::RansTable, 2> tables;
  for (unsigned part = 0; part < 2; ++part) {
    std::array<std::uint16_t, 16> frequencies;
    std::memcpy(frequencies.data(), bricks.tables.data() + 32 * part, sizeof frequencies);
    ASSERT_TRUE(codecs::entropy::RansTable::from_frequencies(frequencies, tables[part]));
  }
  for (std::size_t i = 0; i < bricks.grid.voxels(); ++i) {
    const Operations naive =
        naive_operations(bricks, i, {.stop_bits = true, .keep_outside = false, .delta = true});
    const auto words = bricks.brick(i);
    const std::size_t levels = naive.level_starts.size();
    for (std::size_t l = 0; l + 1 < levels; ++l) ASSERT_EQ(words[l], naive.level_starts[l]);
    const std::uint32_t fine_at = words[levels - 1];
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(words.data() + levels + 1);
    const std::span streams(bytes, 4 * (words.size() - levels - 1 - naive.palette.size()));
    codecs::entropy::RansDecoder coarse(tables[0], streams.first(fine_at));
    codecs::entropy::RansDecoder fine(tables[1], streams.subspan(fine_at));
    for (std::size_t k = 0; k < naive.symbols.size(); ++k) {
      ASSERT_EQ((k < naive.level_starts.back() ? coarse : fine).next(), naive.symbols[k].nibble())
          << "symbol " << k;
    }
    EXPECT_FALSE(coarse.failed());
    EXPECT_EQ(fine.failed(), naive.symbols.size() == naive.level_starts.back())
        << "no symbols, no stream";
  }
}

TEST(SerialOperations, DistancesAreBase8DigitsHighestFirst) {
  std::vector<Operations::Symbol> digits;
  append_distance(1 + 8 * 8 * 3 + 8 * 0 + 5, digits);
  ASSERT_EQ(digits.size(), 3u);
  EXPECT_EQ(digits[0].nibble(), 11);
  EXPECT_EQ(digits[1].nibble(), 8);
  EXPECT_EQ(digits[2].nibble(), 5);
  // Such distances must occur in what the tests above compare.
  const Bricks bricks = encode_bricks(samples::sample("noise_of_700_labels_u16").volume(),
                                      "csgv-nibble", 32, {"delta=1"});
  const Operations naive =
      naive_operations(bricks, 0, {.stop_bits = true, .keep_outside = false, .delta = true});
  std::size_t longest = 0;
  std::size_t run = 0;
  for (const Operations::Symbol& symbol : naive.symbols) {
    run = symbol.digit ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  EXPECT_GE(longest, 3u);
}

}  // namespace
}  // namespace cvr::naive
