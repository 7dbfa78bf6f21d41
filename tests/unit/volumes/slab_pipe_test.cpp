// A decoder on one side, a writer on the other, and what happens when either stops.
#include "volumes/slab_pipe.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <vector>

namespace cvr::volumes {
namespace {

constexpr Extent kExtent{5, 7, 40};

VolumeInfo info_of(const Extent& extent) {
  return {.extent = extent, .type = VoxelType::kU16, .kind = VolumeKind::kLabels, .voxel_unit = {}};
}

std::uint16_t voxel(const Extent& extent, const Coordinate& c) {
  return static_cast<std::uint16_t>(3 * extent.index(c) + 1);
}

/// Delivers slabs of `depth` planes, and notes how many were begun.
struct Maker {
  Extent extent = kExtent;
  std::uint64_t depth = 3;
  std::uint64_t planes = kExtent.z;  ///< delivered before the end
  Expected<void> end;                ///< what it says then
  std::atomic<unsigned>* begun = nullptr;

  Expected<void> operator()(SlabSink& sink) const {
    for (std::uint64_t z0 = 0; z0 < planes; z0 += depth) {
      const std::uint64_t z1 = std::min(z0 + depth, planes);
      if (begun != nullptr) ++*begun;
      auto* out = reinterpret_cast<std::uint16_t*>(sink.begin(z0, z1));
      for (std::uint64_t i = 0; i < (z1 - z0) * extent.x * extent.y; ++i)
        out[i] = static_cast<std::uint16_t>(3 * (z0 * extent.x * extent.y + i) + 1);
      sink.end(z0, z1);
    }
    return end;
  }
};

void expect_box(const SlabPipe& pipe, const Box& box) {
  std::vector<std::uint16_t> found(box.size.voxels());
  pipe.read(box, reinterpret_cast<std::byte*>(found.data()));
  std::size_t i = 0;
  for (std::uint64_t z = 0; z < box.size.z; ++z)
    for (std::uint64_t y = 0; y < box.size.y; ++y)
      for (std::uint64_t x = 0; x < box.size.x; ++x, ++i)
        ASSERT_EQ(found[i],
                  voxel(pipe.info().extent, {box.origin.x + x, box.origin.y + y, box.origin.z + z}))
            << x << ' ' << y << ' ' << z;
}

TEST(SlabPipe, BoxesInAscendingZTakeOnePass) {
  for (const std::uint64_t depth : {1u, 3u, 7u, 40u}) {
    const SlabPipe pipe(info_of(kExtent), "f", Maker{.depth = depth, .end = {}});
    for (std::uint64_t z = 0; z < kExtent.z; z += 8)
      for (std::uint64_t y = 0; y < kExtent.y; y += 3)
        expect_box(pipe, {{0, y, z}, {kExtent.x, std::min<std::uint64_t>(3, kExtent.y - y), 8}});
    EXPECT_EQ(pipe.passes(), 1u);
    expect_box(pipe, {{1, 2, 39}, {3, 4, 1}});
    EXPECT_EQ(pipe.passes(), 1u);
  }
}

TEST(SlabPipe, PlanesThatAreGoneStartTheProducerAnew) {
  const SlabPipe pipe(info_of(kExtent), "f", Maker{.end = {}});
  expect_box(pipe, {{0, 0, 30}, {5, 7, 10}});
  expect_box(pipe, {{2, 1, 0}, {1, 1, 40}});
  expect_box(pipe, {{0, 0, 20}, {5, 7, 5}});
  EXPECT_EQ(pipe.passes(), 2u);
  expect_box(pipe, {{0, 0, 4}, {5, 7, 1}});
  EXPECT_EQ(pipe.passes(), 3u);
}

TEST(SlabPipe, TheProducerWaitsForTheReader) {
  std::atomic<unsigned> begun{0};
  {
    const SlabPipe pipe(info_of(kExtent), "f", Maker{.depth = 1, .end = {}, .begun = &begun});
    expect_box(pipe, {{0, 0, 0}, {5, 7, 4}});
    EXPECT_LE(begun, 4u + 2u) << "one slab that is ready, one whose begin() waits";
  }
  EXPECT_LE(begun, 4u + 2u) << "the destructor stops it";
}

TEST(SlabPipe, AReaderThatNeverReadsStartsNothing) {
  std::atomic<unsigned> begun{0};
  { const SlabPipe pipe(info_of(kExtent), "f", Maker{.end = {}, .begun = &begun}); }
  EXPECT_EQ(begun, 0u);
}

TEST(SlabPipe, AnErrorAfterTheLastSlabComesBeforeTheLastPlane) {
  const SlabPipe pipe(info_of(kExtent), "f.cvr",
                      Maker{.end = fail(ErrorCode::kMalformed, "bytes follow")});
  expect_box(pipe, {{0, 0, 0}, {5, 7, 39}});
  std::vector<std::byte> plane(5 * 7 * 2);
  for (int again = 0; again < 2; ++again) {
    try {
      pipe.read({{0, 0, 39}, {5, 7, 1}}, plane.data());
      FAIL() << "the last plane was handed out";
    } catch (const InputError& error) {
      EXPECT_STREQ(error.what(), "f.cvr: bytes follow");
    }
  }
}

TEST(SlabPipe, AnErrorInTheMiddleIsTold) {
  const SlabPipe pipe(info_of(kExtent), "f",
                      Maker{.planes = 9, .end = fail(ErrorCode::kChecksum, "no")});
  std::vector<std::byte> all(kExtent.voxels() * 2);
  EXPECT_THROW(pipe.read({{0, 0, 0}, kExtent}, all.data()), InputError);
  const SlabPipe memory(info_of(kExtent), "f",
                        Maker{.planes = 9, .end = fail(ErrorCode::kOutOfMemory, "no")});
  EXPECT_THROW(memory.read({{0, 0, 0}, kExtent}, all.data()), std::bad_alloc);
  const SlabPipe thrown(info_of(kExtent), "f",
                        [](SlabSink&) -> Expected<void> { throw std::range_error("x"); });
  EXPECT_THROW(thrown.read({{0, 0, 0}, kExtent}, all.data()), std::range_error);
}

TEST(SlabPipe, AProducerThatDeliversTooLittleOrOutOfOrderIsRefused) {
  std::vector<std::byte> all(kExtent.voxels() * 2);
  const SlabPipe short_one(info_of(kExtent), "f", Maker{.planes = 39, .end = {}});
  EXPECT_THROW(short_one.read({{0, 0, 0}, kExtent}, all.data()), InputError);
  const SlabPipe gap(info_of(kExtent), "f", [](SlabSink& sink) -> Expected<void> {
    sink.begin(1, 2);
    return {};
  });
  EXPECT_THROW(gap.read({{0, 0, 0}, kExtent}, all.data()), std::logic_error);
}

TEST(SlabPipe, ManyShortLivesEnd) {
  for (unsigned planes = 0; planes < 200; ++planes) {
    const SlabPipe pipe(info_of(kExtent), "f", Maker{.depth = 1 + planes % 5, .end = {}});
    if (planes % 41 > 0)
      expect_box(pipe, {{0, 0, planes % 7}, {5, 7, std::min<std::uint64_t>(planes % 41, 33)}});
  }
}

}  // namespace
}  // namespace cvr::volumes
