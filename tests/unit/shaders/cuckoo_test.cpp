// The hash functions of the voxel cache, and a table over them: positions and keys of every size of
// table, the values themselves, their spread, and cells that collide in each way there is.
#include "tests/samples/cuckoo.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "shaders/shared/shared.hpp"

namespace cvr {
namespace {

using samples::CuckooCell;
using samples::CuckooTable;

constexpr std::uint32_t kAllOnes = 0x7fffffffu;  ///< of the 31 bits of a key

std::uint32_t bits_of(std::uint32_t size) {
  return static_cast<std::uint32_t>(std::bit_width(size - 1));
}

std::vector<CuckooCell> box(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::vector<CuckooCell> cells;
  for (std::uint32_t c = 0; c < z; ++c) {
    for (std::uint32_t b = 0; b < y; ++b) {
      for (std::uint32_t a = 0; a < x; ++a) cells.push_back({a, b, c, 0});
    }
  }
  return cells;
}

TEST(Cuckoo, PositionsLieInTablesOfEverySize) {
  std::mt19937 random(5);
  std::vector<CuckooCell> cells{
      {0, 0, 0, 0}, {UINT32_MAX, UINT32_MAX, UINT32_MAX, 6}, {32767, 32767, 32767, 6}};
  for (int i = 0; i < 2000; ++i) {
    const auto axis = [&] { return static_cast<std::uint32_t>(random()) & 32767; };
    cells.push_back({axis(), axis(), axis(), static_cast<std::uint32_t>(random()) % 7});
  }
  std::vector<std::uint32_t> sizes{3, 1000, 131071 * 3 + 7, 1000003, UINT32_MAX};
  for (std::uint32_t bits = 1; bits < 32; ++bits) {
    for (const std::uint32_t size : {(1u << bits) - 1, 1u << bits, (1u << bits) + 1}) {
      if (size >= 2) sizes.push_back(size);
    }
  }
  for (const std::uint32_t size : sizes) {
    const std::uint32_t bits = bits_of(size);
    for (const CuckooCell& c : cells) {
      const std::uint32_t first = shaders::cvr_cuckoo_first(c.x, c.y, c.z, bits, size);
      const std::uint32_t second = shaders::cvr_cuckoo_second(
          shaders::cvr_cuckoo_key(c.x, c.y, c.z, c.lod), first, bits, size);
      ASSERT_LT(first, size) << c.x << " " << c.y << " " << c.z;
      ASSERT_LT(second, size) << c.x << " " << c.y << " " << c.z << " of level " << c.lod;
    }
  }
}

/// pcg4d as its authors print it, and the sum of the paper.
std::uint32_t unguarded_key(std::uint32_t x, std::uint32_t y, std::uint32_t z, std::uint32_t w) {
  std::uint32_t v[4] = {x, y, z, w};
  for (std::uint32_t& word : v) word = word * 1664525u + 1013904223u;
  for (int turn = 0; turn < 2; ++turn) {
    v[0] += v[1] * v[3];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
    v[3] += v[1] * v[2];
    if (turn == 0) {
      for (std::uint32_t& word : v) word ^= word >> 16;
    }
  }
  return (5 * v[0] ^ 149 * v[1] ^ 61 * v[2] ^ 2887 * v[3]) & kAllOnes;
}

TEST(Cuckoo, NoKeyIsAllOnes) {
  // The first cell in the order of z, y, x within 1024 x 1024 x 1024 whose key would be: an entry
  // with it would look free once it is moved.
  ASSERT_EQ(unguarded_key(853, 561, 453, 0), kAllOnes);
  EXPECT_EQ(CuckooTable::key({853, 561, 453, 0}), kAllOnes - 1);
  for (const CuckooCell& cell : box(64, 64, 64)) {
    const std::uint32_t key = CuckooTable::key(cell);
    ASSERT_LT(key, kAllOnes);
    ASSERT_EQ(key, unguarded_key(cell.x, cell.y, cell.z, cell.lod));
  }
}

TEST(Cuckoo, ValuesAreTheseAndNoOthers) {
  // First and second position in tables of 2^17 and of 1,000,003 entries.
  const struct {
    CuckooCell cell;
    std::uint32_t first, first_of_many, key, second, second_of_many;
  } known[] = {{{0, 0, 0, 0}, 57266, 458129, 0x15358c39, 128598, 346815},
               {{1, 0, 0, 0}, 602, 4816, 0x4933b2b5, 83169, 224605},
               {{0, 1, 0, 0}, 60231, 481849, 0x4870fee9, 28092, 571108},
               {{0, 0, 1, 0}, 65196, 521574, 0x6b52c40b, 117016, 524695},
               {{0, 0, 0, 1}, 57266, 458129, 0x5c10973c, 127279, 992133},
               {{17, 300, 4095, 3}, 99775, 798206, 0x4cd8c4e5, 28526, 954070},
               {{32767, 32767, 32767, 6}, 38755, 310046, 0x068bc764, 117466, 204765},
               {{12, 34, 56, 2}, 34377, 275017, 0x7d121755, 79244, 279948}};
  const CuckooTable table(1 << 17), odd(1000003);
  for (const auto& k : known) {
    EXPECT_EQ(table.first(k.cell), k.first);
    EXPECT_EQ(odd.first(k.cell), k.first_of_many);
    EXPECT_EQ(CuckooTable::key(k.cell), k.key);
    EXPECT_EQ(table.second(k.cell), k.second);
    EXPECT_EQ(odd.second(k.cell), k.second_of_many);
  }
}

/// How many standard deviations chi-square is off its mean, when positions below 2^bits - size are
/// twice as likely as others.
double deviations(const std::vector<std::uint32_t>& counts) {
  const auto size = static_cast<std::uint32_t>(counts.size());
  const double words = std::exp2(bits_of(size));
  double total = 0, chi = 0;
  for (const std::uint32_t count : counts) total += count;
  for (std::uint32_t position = 0; position < size; ++position) {
    const double expected = total * (position < words - size ? 2 : 1) / words;
    chi += (counts[position] - expected) * (counts[position] - expected) / expected;
  }
  return (chi - (size - 1)) / std::sqrt(2.0 * (size - 1));
}

TEST(Cuckoo, NeighboursSpreadOverTheTable) {
  std::mt19937 random(11);
  for (const std::uint32_t size : {1024u, 4096u, 5000u, 4097u, 6007u}) {
    for (int repetition = 0; repetition < 4; ++repetition) {
      const auto origin = [&] { return static_cast<std::uint32_t>(random()) & 16383; };
      const CuckooCell from{origin(), origin(), origin(), 0};
      const CuckooTable table(size);
      std::vector<std::uint32_t> firsts(size), seconds(size);
      for (const CuckooCell& at : box(48, 48, 48)) {
        const CuckooCell cell{from.x + at.x, from.y + at.y, from.z + at.z, 0};
        ++firsts[table.first(cell)];
        ++seconds[table.second(cell)];
      }
      EXPECT_LT(std::abs(deviations(firsts)), 6)
          << size << " first, from " << from.x << " " << from.y << " " << from.z;
      EXPECT_LT(std::abs(deviations(seconds)), 6)
          << size << " second, from " << from.x << " " << from.y << " " << from.z;
    }
  }
}

TEST(Cuckoo, LevelsOfARegionShareThePositionAndNotTheKey) {
  const CuckooTable table(131072);
  for (std::uint32_t lod = 1; lod < 7; ++lod) {
    EXPECT_EQ(table.first({64, 128, 192, lod}), table.first({64, 128, 192, 0}));
    EXPECT_NE(CuckooTable::key({64, 128, 192, lod}), CuckooTable::key({64, 128, 192, 0}));
  }
}

TEST(Cuckoo, CellsOfOnePositionMoveAndAreLost) {
  constexpr std::uint32_t kSize = 131072;
  const auto found = samples::find_eviction(box(64, 64, 64), kSize);
  ASSERT_TRUE(found);
  const auto& [a, b, c, d] = *found;
  CuckooTable table(kSize);
  ASSERT_EQ(table.first(a), table.first(b));
  ASSERT_EQ(table.first(b), table.first(c));
  ASSERT_EQ(table.second(a), table.first(d));
  table.insert(a, 1);
  table.insert(b, 2);
  EXPECT_EQ(table.find(a), 1u) << "at its second position";
  EXPECT_EQ(table.find(b), 2u);
  EXPECT_EQ(table.ejections(), 1u);
  table.insert(c, 3);
  EXPECT_EQ(table.find(a), 1u);
  EXPECT_EQ(table.find(b), 2u);
  EXPECT_EQ(table.find(c), 3u);
  EXPECT_EQ(table.ejections(), 2u);
  EXPECT_EQ(table.losses(), 0u);
  table.insert(d, 4);
  EXPECT_EQ(table.find(a), std::nullopt) << "d lies where a was moved to";
  EXPECT_EQ(table.find(d), 4u);
  EXPECT_EQ(table.ejections(), 2u);
  EXPECT_EQ(table.losses(), 1u);
}

TEST(Cuckoo, ATableCannotTellCellsOfOneKeyAndPositionApart) {
  // 31 bits of key and 6 or 17 of the position: small tables have such cells soon, those of a
  // mebibyte at some size.
  for (const std::uint32_t least : {64u, 131072u}) {
    const auto found = samples::find_key_collision(box(64, 64, 64), least);
    ASSERT_TRUE(found) << least;
    CuckooTable table(found->size);
    ASSERT_NE(found->a, found->b);
    ASSERT_EQ(CuckooTable::key(found->a), CuckooTable::key(found->b));
    ASSERT_EQ(table.first(found->a), table.first(found->b));
    EXPECT_EQ(table.second(found->a), table.second(found->b));
    EXPECT_EQ(table.find(found->b), std::nullopt);
    table.insert(found->a, 7);
    EXPECT_EQ(table.find(found->b), 7u) << "a's label";
  }
}

TEST(Cuckoo, WhatIsNotLostIsThere) {
  for (const std::uint32_t size : {2u, 3u, 64u, 1000u}) {
    CuckooTable table(size);
    std::uint64_t inserted = 0, own_places = 0;
    for (const CuckooCell& cell : box(8, 8, 8)) {
      table.insert(cell, 1 + cell.x);
      ++inserted;
      ASSERT_EQ(table.occupied(), inserted - table.losses()) << size;
      // Missing at once only where what it pushed out has one place for both positions.
      if (!table.find(cell)) ++own_places;
    }
    EXPECT_GT(table.ejections(), 0u);
    EXPECT_GT(table.losses(), 0u);
    EXPECT_LT(own_places, inserted / 2);
    EXPECT_EQ(own_places > 0, size <= 64) << "in larger tables one position seldom is both";
  }
}

}  // namespace
}  // namespace cvr
