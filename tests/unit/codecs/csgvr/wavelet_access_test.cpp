// The shared decoder text of CSGV-R (operation, rank, index, label) against the naive list of
// symbols, node by node.
#include <gtest/gtest.h>

#include "shaders/shared/shared.hpp"
#include "tests/unit/codecs/csgv/encoded_bricks.hpp"

namespace cvr::naive {
namespace {

using shaders::CsgvrBrick;
using shaders::Words;

std::uint32_t morton(const Position& p) {
  std::uint32_t code = 0;
  for (unsigned bit = 0; bit < 6; ++bit) {
    code |=
        static_cast<std::uint32_t>((p.x >> bit & 1) | (p.y >> bit & 1) << 1 | (p.z >> bit & 1) << 2)
        << (3 * bit);
  }
  return code;
}

/// Every symbol, its stop bit and the number of "advance" before it.
void check_symbols(Words words, const CsgvrBrick& brick, const Operations& naive, bool stop_bits) {
  std::uint32_t advances = 0;
  std::uint32_t stops = 0;
  for (std::uint32_t i = 0; i < naive.symbols.size(); ++i) {
    const auto& symbol = naive.symbols[i];
    std::uint32_t before = 77;
    ASSERT_EQ(cvr_csgvr_operation(words, brick, i, before), symbol.code) << "symbol " << i;
    ASSERT_EQ(before, symbol.code >= kAdvance ? advances : 0) << "symbol " << i;
    if (symbol.code == kAdvance) ++advances;
    if (!stop_bits) continue;
    ASSERT_EQ(cvr_rank1(words, brick.s, i), stops);
    ASSERT_EQ(cvr_bit(words, brick.s, i), symbol.stop ? 1u : 0u) << "symbol " << i;
    stops += symbol.stop ? 1 : 0;
  }
}

/// Every node of every level: its place in the stream, or that of the ancestor with the stop bit,
/// and its label.
void check_nodes(Words words, const CsgvrBrick& brick, const Operations& naive, const Grid& grid,
                 bool stop_bits) {
  std::vector<std::vector<std::uint32_t>> place(grid.size());
  for (std::size_t l = 0; l < grid.size(); ++l) {
    place[l].assign(grid[l].nodes.size(), ~0u);
    for (std::size_t k = 0; k < naive.nodes[l].size(); ++k) {
      place[l][morton(naive.nodes[l][k])] = naive.level_starts[l] + static_cast<std::uint32_t>(k);
    }
  }
  for (std::size_t l = 0; l < grid.size(); ++l) {
    const int side = grid[l].side;
    for (int i = 0; i < side * side * side; ++i) {
      const Position p{i % side, i / side % side, i / (side * side)};
      std::size_t coded = l;
      std::uint32_t code = morton(p);
      for (std::size_t a = 0; stop_bits && a < l; ++a) {
        const std::uint32_t ancestor = morton(p) >> (3 * (l - a));
        if (place[a][ancestor] == ~0u || !naive.symbols[place[a][ancestor]].stop) continue;
        coded = a;
        code = ancestor;
        break;
      }
      std::uint32_t n = morton(p);
      auto level = static_cast<std::uint32_t>(l);
      ASSERT_EQ(cvr_csgvr_index(words, brick, n, level), place[coded][code])
          << "level " << l << ", node " << i;
      ASSERT_EQ(n, code);
      ASSERT_EQ(level, coded);
      std::uint32_t index = 0;
      std::uint32_t hops = 0;
      ASSERT_TRUE(cvr_csgvr_palette_index(words, brick, morton(p), static_cast<std::uint32_t>(l),
                                          index, hops));
      ASSERT_GE(hops, 1u);
      ASSERT_EQ(cvr_csgvr_label(words, brick, index), grid[l].at(p.x, p.y, p.z).label)
          << "level " << l << ", node " << i;
    }
  }
}

void check_brick(const Bricks& bricks, std::size_t i, bool stop_bits) {
  Grid grid = make_grid(bricks.side, bricks.voxel(i));
  fill_outside(grid);
  const Operations naive =
      make_operations(grid, {.stop_bits = stop_bits, .keep_outside = true, .delta = false});
  const auto words = bricks.brick(i);
  const Words at{words.data()};
  const CsgvrBrick brick = cvr_csgvr_open(at, static_cast<std::uint32_t>(words.size()),
                                          static_cast<std::uint32_t>(grid.size()), stop_bits);
  for (std::size_t l = 0; l < grid.size(); ++l) ASSERT_EQ(words[l], naive.level_starts[l]);
  ASSERT_EQ(brick.palette_size, naive.palette.size());
  check_symbols(at, brick, naive, stop_bits);
  if (testing::Test::HasFatalFailure()) return;
  check_nodes(at, brick, naive, grid, stop_bits);
}

class WaveletAccess : public testing::TestWithParam<std::string> {};

TEST_P(WaveletAccess, EqualsTheNaiveList) {
  for (const int side : {16, 32, 64}) {
    for (const bool stop_bits : {false, true}) {
      const Bricks bricks = encode_bricks(samples::sample(GetParam()).volume(),
                                          stop_bits ? "csgvr-sb" : "csgvr", side);
      // First, last and one brick between: corner, border and inner bricks.
      const std::size_t last = bricks.grid.voxels() - 1;
      for (const std::size_t i : std::set<std::size_t>{0, last / 2, last}) {
        SCOPED_TRACE(testing::Message()
                     << "brick " << i << " of side " << side << ", stop bits " << stop_bits);
        check_brick(bricks, i, stop_bits);
        if (HasFatalFailure()) return;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Zoo, WaveletAccess, testing::ValuesIn(stored_as_they_are()),
                         [](const auto& info) { return info.param; });

TEST(WaveletAccess, ABrickOf64WithAllLabelsDistinctHas299593Nodes) {
  const Bricks bricks =
      encode_bricks(samples::sample("every_voxel_its_label_64x64x66_u32").volume(), "csgvr-sb", 64);
  const auto words = bricks.brick(0);
  const CsgvrBrick brick =
      shaders::cvr_csgvr_open({words.data()}, static_cast<std::uint32_t>(words.size()), 7, true);
  const std::uint32_t first_level =
      words[brick.z_at + 5];  // W_1: the first wavelet level has one bit a node
  EXPECT_EQ(first_level, 299593u);
  // Longer than the 2^20 that a 20-bit rank could count, were every bit set; there is at most one
  // 1-bit per symbol.
  EXPECT_GT(words[8], 1u << 20);
  EXPECT_EQ(cvr_rank1({words.data()}, brick.w, words[8]), 299593u);
  EXPECT_EQ(brick.palette_size, 262144u);
}

}  // namespace
}  // namespace cvr::naive
