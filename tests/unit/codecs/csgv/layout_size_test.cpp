// Exact sizes of the published brick layouts.
#include <gtest/gtest.h>

#include "tests/unit/codecs/csgv/encoded_bricks.hpp"

namespace cvr::naive {
namespace {

std::size_t constant_brick_words(std::string_view codec, int side) {
  const auto s = static_cast<std::uint64_t>(side);
  const volumes::VolumeInfo info{
      .extent = {s, s, s}, .type = volumes::VoxelType::kU8, .voxel_unit = {}};
  const Bricks bricks =
      encode_bricks(samples::make_labels(info, [](auto&) { return 7; }), codec, side);
  EXPECT_EQ(bricks.payload.published_bytes, 4 * (bricks.starts.size() + bricks.words.size()));
  return bricks.words.size();
}

TEST(LayoutSize, ConstantBricks) {
  // Level starts, palette size, one word of operations, one palette entry.
  EXPECT_EQ(constant_brick_words("csgv-nibble", 32), 9u);
  EXPECT_EQ(constant_brick_words("csgv-nibble", 16), 8u);
  EXPECT_EQ(constant_brick_words("csgv-nibble", 64), 10u);
  EXPECT_EQ(constant_brick_words("csgvr-sb", 32), 27u);
  EXPECT_EQ(constant_brick_words("csgvr-sb", 64), 28u);
  // No stop bits: (8^6 - 1) / 7 nodes, one bit each but for the root's five, 64-bit entries and
  // words.
  constexpr std::size_t kBits = 37449 + 4;
  EXPECT_EQ(constant_brick_words("csgvr", 32),
            6 + 1 + 1 + 9 + 2 * (kBits / 1280 + 1) + 2 * ((kBits + 63) / 64) + 1);
  EXPECT_EQ(constant_brick_words("csgvr-nibble", 32), 6 + 1 + (37449u + 7) / 8 + 1);
}

TEST(LayoutSize, PublishedBytesAreStartTableAndBricks) {
  for (const char* codec : {"csgv-nibble", "csgv-rans", "csgvr-nibble", "csgvr", "csgvr-sb"}) {
    const Bricks bricks =
        encode_bricks(samples::sample("odd_sides_65x33x70_u32").volume(), codec, 32);
    EXPECT_EQ(bricks.grid, (volumes::Extent{3, 2, 3}));
    EXPECT_EQ(bricks.payload.published_bytes, 4 * (19 + bricks.words.size())) << codec;
  }
}

}  // namespace
}  // namespace cvr::naive
