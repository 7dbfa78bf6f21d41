// The plan of parts in which a box is read: whole chunks, as few parts as can be.
#include "volumes/io/hdf5_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace cvr::volumes {
namespace {

constexpr std::array<std::size_t, 3> kZyx{2, 1, 0};

/// The parts; that they tile the box and keep to the limit has then been checked.
std::vector<Box> checked(const Box& box, const ChunkedArray& array, std::uint64_t most_bytes) {
  const std::vector<Box> parts = plan_parts(box, array, most_bytes);
  std::vector<int> times(box.size.voxels(), 0);
  for (const Box& part : parts) {
    EXPECT_GT(part.size.voxels(), 0u);
    EXPECT_LE(part.size.voxels() * array.voxel_bytes, std::max(most_bytes, array.voxel_bytes));
    for (std::uint64_t i = 0; i < part.size.voxels(); ++i) {
      const Coordinate at{part.origin.x - box.origin.x + i % part.size.x,
                          part.origin.y - box.origin.y + i / part.size.x % part.size.y,
                          part.origin.z - box.origin.z + i / (part.size.x * part.size.y)};
      if (!box.size.contains(at)) {
        ADD_FAILURE() << "a part reaches out of the box";
        return parts;
      }
      ++times[box.size.index(at)];
    }
  }
  EXPECT_EQ(std::count(times.begin(), times.end(), 1), static_cast<std::ptrdiff_t>(times.size()));
  return parts;
}

/// How many parts touch the chunk that the most parts touch.
unsigned most_inflations(const std::vector<Box>& parts, const ChunkedArray& array) {
  std::map<std::array<std::uint64_t, 3>, unsigned> touched;
  for (const Box& part : parts) {
    const auto chunks = [](std::uint64_t begin, std::uint64_t size, std::uint64_t chunk) {
      return std::pair{begin / chunk, (begin + size - 1) / chunk};
    };
    const auto [x0, x1] = chunks(part.origin.x, part.size.x, array.chunk[0]);
    const auto [y0, y1] = chunks(part.origin.y, part.size.y, array.chunk[1]);
    const auto [z0, z1] = chunks(part.origin.z, part.size.z, array.chunk[2]);
    for (std::uint64_t z = z0; z <= z1; ++z) {
      for (std::uint64_t y = y0; y <= y1; ++y) {
        for (std::uint64_t x = x0; x <= x1; ++x) ++touched[{x, y, z}];
      }
    }
  }
  unsigned most = 0;
  for (const auto& [chunk, count] : touched) most = std::max(most, count);
  return most;
}

TEST(Hdf5Parts, ABoxThatFitsIsOnePart) {
  const Box box{{3, 5, 7}, {20, 30, 11}};
  const std::uint64_t bytes =
      std::uint64_t{2} * (8 * 8 * 8) * 3 * 5 * 3;  // of the chunks it touches
  const ChunkedArray array{{8, 8, 8}, kZyx, 2};
  const std::vector<Box> parts = checked(box, array, bytes);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].size, box.size);
}

TEST(Hdf5Parts, LayersOfChunksAboveAndBelowTheLimit) {
  // A layer of chunks is 64 x 64 x 8 voxels: 32,768 bytes.
  const ChunkedArray array{{8, 8, 8}, kZyx, 1};
  const Box box{{0, 0, 0}, {64, 64, 24}};
  struct Expected {
    std::uint64_t most_bytes;
    std::size_t parts;
  };
  for (const auto& [most_bytes, count] : {Expected{98304, 1},
                                          {98303, 2},
                                          {65536, 2},
                                          {65535, 3},
                                          {32768, 3},
                                          {32767, 6},
                                          {16384, 6},
                                          {4096, 24},
                                          {4095, 48},
                                          {512, 192}}) {
    const std::vector<Box> parts = checked(box, array, most_bytes);
    EXPECT_EQ(parts.size(), count) << most_bytes;
    EXPECT_EQ(most_inflations(parts, array), 1u) << most_bytes;
  }
}

TEST(Hdf5Parts, ChunksAreInflatedOnceWhereverABoxBeginsAndEnds) {
  // Extents and origins that are no multiples of the chunk.
  const ChunkedArray array{{7, 5, 3}, kZyx, 2};
  for (const Coordinate origin :
       {Coordinate{0, 0, 0}, {1, 0, 2}, {6, 4, 2}, {7, 5, 3}, {8, 9, 1}}) {
    for (const Extent size : {Extent{1, 1, 1}, {7, 5, 3}, {8, 6, 4}, {29, 23, 17}, {30, 1, 13}}) {
      for (const std::uint64_t most_bytes : {210, 211, 419, 420, 1000, 5000, 100000}) {
        const auto parts = checked({origin, size}, array, most_bytes);
        EXPECT_EQ(most_inflations(parts, array), 1u)
            << most_bytes << " bytes, from " << origin.x << ' ' << origin.y << ' ' << origin.z;
      }
    }
  }
}

TEST(Hdf5Parts, AChunkAboveTheLimitIsCutAlongItsSlowAxis) {
  const ChunkedArray array{{16, 16, 16}, kZyx, 4};  // 16 KiB a chunk, 1 KiB a plane of it
  const std::vector<Box> parts = checked({{0, 0, 0}, {16, 16, 16}}, array, 4096);
  ASSERT_EQ(parts.size(), 4u);
  for (const Box& part : parts) EXPECT_EQ(part.size, (Extent{16, 16, 4}));
  // The file's slowest axis may be x.
  const ChunkedArray turned{{16, 16, 16}, {0, 1, 2}, 4};
  for (const Box& part : checked({{0, 0, 0}, {16, 16, 16}}, turned, 4096))
    EXPECT_EQ(part.size, (Extent{4, 16, 16}));
}

TEST(Hdf5Parts, ALimitBelowALineCutsLines) {
  const ChunkedArray array{{16, 4, 4}, kZyx, 1};
  for (const Box& part : checked({{0, 0, 0}, {16, 4, 4}}, array, 8))
    EXPECT_EQ(part.size, (Extent{8, 1, 1}));
  EXPECT_EQ(checked({{0, 0, 0}, {4, 1, 1}}, {{4, 1, 1}, kZyx, 8}, 1).size(), 4u)
      << "a voxel is read whatever the limit";
}

TEST(Hdf5Parts, OneVoxel) {
  for (const ChunkedArray& array :
       {ChunkedArray{{1, 1, 1}, kZyx, 1}, {{64, 64, 64}, kZyx, 8}, {{3, 1, 7}, {1, 0, 2}, 2}}) {
    const std::vector<Box> parts = checked({{130, 67, 5}, {1, 1, 1}}, array, 1 << 20);
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].origin, (Coordinate{130, 67, 5}));
  }
}

TEST(Hdf5Parts, AnArrayWithoutChunksIsReadAlongItsFastAxes) {
  const ChunkedArray array{{1, 1, 1}, kZyx, 1};
  for (const Box& part : checked({{0, 0, 0}, {10, 10, 10}}, array, 250)) {
    EXPECT_EQ(part.size.x, 10u);
    EXPECT_EQ(part.size.y, 10u);
    EXPECT_EQ(part.size.z, 2u);
  }
}

}  // namespace
}  // namespace cvr::volumes
