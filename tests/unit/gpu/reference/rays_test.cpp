// Rays against volumes whose answer is known: by hand for the hard ones, by brute force over all
// cells for random ones.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "gpu/reference/view.hpp"
#include "gpu/reference/walk.hpp"
#include "tests/unit/gpu/reference/small_volumes.hpp"

namespace cvr::gpu {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Every voxel has a label of its own: 1 + x + 4 (y + 4 z).
volumes::Volume numbered() {
  return make_volume({4, 4, 4}, [](auto x, auto y, auto z) { return 1 + x + 4 * (y + 4 * z); });
}
constexpr std::uint64_t number(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return 1 + x + 4 * (y + 4 * z);
}

TEST(Rays, OneVoxelFromSixSides) {
  const auto volume = make_volume(
      {9, 7, 5}, [](auto x, auto y, auto z) { return x == 4 && y == 3 && z == 2 ? 5 : 0; });
  const ReferenceRenderer renderer(volume, 16, 1);
  const Vector3 middle{4.5, 3.5, 2.5};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vector3 origin = middle, direction{0, 0, 0};
      origin[axis] += side * 20;
      direction[axis] = -side;
      EXPECT_EQ(hit(renderer, origin, direction), 5u);
      direction[axis] = side;
      EXPECT_EQ(hit(renderer, origin, direction), kNoLabel) << "it lies behind";
      direction[axis] = -side;
      for (const double off : {-0.51, 0.51}) {
        Vector3 beside = origin;
        beside[(axis + 1) % 3] += off;
        EXPECT_EQ(hit(renderer, beside, direction), kNoLabel);
      }
    }
  }
}

TEST(Rays, AlongAnAxisWithZeroComponents) {
  const auto volume = numbered();
  const ReferenceRenderer renderer(volume, 16, 1);
  EXPECT_EQ(hit(renderer, {-3, 2.5, 1.5}, {1, 0, 0}), number(0, 2, 1));
  EXPECT_EQ(hit(renderer, {9, 2.5, 1.5}, {-1, 0, 0}), number(3, 2, 1));
  EXPECT_EQ(hit(renderer, {2.5, 1.5, 9}, {-0.0, -0.0, -1}), number(2, 1, 3));
  EXPECT_EQ(hit(renderer, {2.5, 1.5, -1}, {-0.0, 0.0, 1}), number(2, 1, 0));
  EXPECT_EQ(hit(renderer, {-3, 4.5, 1.5}, {1, 0, 0}), kNoLabel);
}

TEST(Rays, InThePlaneOfAFace) {
  const auto volume = numbered();
  const ReferenceRenderer renderer(volume, 16, 1);
  EXPECT_EQ(hit(renderer, {-3, 2, 1}, {1, 0, 0}), number(0, 2, 1)) << "floor tells the cell";
  EXPECT_EQ(hit(renderer, {-3, 0, 0}, {1, 0, 0}), number(0, 0, 0));
  EXPECT_EQ(hit(renderer, {-3, 4, 1}, {1, 0, 0}), kNoLabel) << "the far face";
  EXPECT_EQ(hit(renderer, {-3, 1, 4}, {1, 0, -0.0}), kNoLabel);
}

TEST(Rays, StartingOnFacesEdgesCornersAndInside) {
  const auto volume = numbered();
  const ReferenceRenderer renderer(volume, 16, 1);
  EXPECT_EQ(hit(renderer, {2.2, 1.7, 3.1}, {0.3, -0.2, 0.1}), number(2, 1, 3)) << "inside";
  EXPECT_EQ(hit(renderer, {2, 1.5, 1.5}, {1, 0, 0}), number(2, 1, 1)) << "on a face, forwards";
  EXPECT_EQ(hit(renderer, {2, 1.5, 1.5}, {-1, 0, 0}), number(1, 1, 1)) << "and backwards";
  EXPECT_EQ(hit(renderer, {2, 3, 1.5}, {-1, 1, 0}), number(1, 3, 1)) << "on an edge";
  EXPECT_EQ(hit(renderer, {2, 3, 1}, {-1, -1, -1}), number(1, 2, 0)) << "on a corner";
  EXPECT_EQ(hit(renderer, {2, 3, 1}, {-1, 1, 0}), number(1, 3, 1));
  EXPECT_EQ(hit(renderer, {0, 0, 0}, {1, 1, 1}), number(0, 0, 0)) << "on a corner of the volume";
  EXPECT_EQ(hit(renderer, {4, 4, 4}, {-1, -1, -1}), number(3, 3, 3));
  EXPECT_EQ(hit(renderer, {4, 4, 4}, {1, 1, 1}), kNoLabel) << "leaving at once";
  EXPECT_EQ(hit(renderer, {0, 1.5, 1.5}, {-1, 0, 0}), kNoLabel);
  EXPECT_EQ(hit(renderer, {4, 1.5, 1.5}, {1, 0.1, 0}), kNoLabel);
}

TEST(Rays, CrossingsAtTheSameTimeGoXThenYThenZ) {
  // The diagonal through all corners: what lies beside it in the wrong order must not be seen.
  const auto seen = [](std::uint64_t x, std::uint64_t y, std::uint64_t z, const Vector3& from,
                       const Vector3& direction) {
    const auto volume = make_volume(
        {4, 4, 4}, [&](auto i, auto j, auto k) { return i == x && j == y && k == z ? 9 : 0; });
    return hit(ReferenceRenderer(volume, 16, 1), from, direction) == 9;
  };
  const Vector3 low{0.5, 0.5, 0.5}, high{3.5, 3.5, 3.5};
  EXPECT_TRUE(seen(1, 0, 0, low, {1, 1, 1}));
  EXPECT_TRUE(seen(1, 1, 0, low, {1, 1, 1}));
  EXPECT_TRUE(seen(1, 1, 1, low, {1, 1, 1}));
  EXPECT_FALSE(seen(0, 1, 0, low, {1, 1, 1}));
  EXPECT_FALSE(seen(0, 0, 1, low, {1, 1, 1}));
  EXPECT_FALSE(seen(1, 0, 1, low, {1, 1, 1}));
  EXPECT_TRUE(seen(2, 3, 3, high, {-1, -1, -1}));
  EXPECT_TRUE(seen(2, 2, 3, high, {-1, -1, -1}));
  EXPECT_FALSE(seen(3, 2, 3, high, {-1, -1, -1}));
  // From outside: x enters while y leaves at the same time; x comes first, so the voxel is seen,
  // and not the other way round.
  EXPECT_TRUE(seen(0, 3, 2, {-2, 2, 2.5}, {1, 1, 0}));
  EXPECT_FALSE(seen(3, 0, 2, {2, -2, 2.5}, {1, 1, 0}));
}

TEST(Rays, KnowTheFaceThroughWhichTheyEnter) {
  const auto volume = numbered();
  const LabelBricks bricks(volume, 16, 1);
  const View view(bricks, plain_scene(), {}, 1);
  const auto face = [&](const Vector3& from, const Vector3& direction) {
    const Walk walk(view, {from, direction});
    EXPECT_FALSE(walk.at_end());
    return walk.face();
  };
  EXPECT_EQ(face({-1, 1.5, 1.5}, {1, 0.1, 0.1}), 0u);
  EXPECT_EQ(face({1.5, 9, 1.5}, {0, -1, 0}), 1u);
  EXPECT_EQ(face({-1, -1, 1.5}, {1, 1, 0}), 1u) << "at an edge x is crossed before y";
  EXPECT_EQ(face({-1, 1.5, 5}, {1, 0, -1}), 2u);
  EXPECT_EQ(face({-1, -1, -1}, {1, 1, 1}), 2u) << "and z last";
  EXPECT_EQ(face({1.5, 1.5, 1.5}, {1, 0, 0}), std::nullopt);
  EXPECT_EQ(face({0, 1.5, 1.5}, {1, 0, 0}), std::nullopt)
      << "a ray that starts on a plane begins in the cell";
}

TEST(Rays, UnusableDirectionsSeeNothing) {
  const auto volume = numbered();
  const ReferenceRenderer renderer(volume, 16, 1);
  const Vector3 inside{1.5, 1.5, 1.5};
  EXPECT_EQ(hit(renderer, inside, {0, 0, 0}), kNoLabel);
  EXPECT_EQ(hit(renderer, inside, {-0.0, 0, -0.0}), kNoLabel);
  EXPECT_EQ(hit(renderer, inside, {kNaN, 1, 0}), kNoLabel);
  EXPECT_EQ(hit(renderer, inside, {1, kInfinity, 0}), kNoLabel);
  EXPECT_EQ(hit(renderer, {1.5, kNaN, 1.5}, {1, 0, 0}), kNoLabel);
  EXPECT_EQ(hit(renderer, {-1, 1.5, 1.5}, {1e-310, 0, 0}), kNoLabel) << "it never arrives";
  EXPECT_EQ(hit(renderer, inside, {1e-310, 0, 0}), number(1, 1, 1));
}

TEST(Rays, FromAMillionVoxelsAway) {
  const auto volume = numbered();
  const ReferenceRenderer renderer(volume, 16, 1);
  EXPECT_EQ(hit(renderer, {-1e6, 2.5, 1.5}, {1, 0, 0}), number(0, 2, 1));
  EXPECT_EQ(hit(renderer, {1e6, 1e6 - 1, 1e6 - 2}, {-1, -1, -1}), number(3, 3, 2))
      << "at (4, 3, 2), by x first";
  EXPECT_EQ(hit(renderer, {1e6, 1e6 - 0.75, 1e6 - 1.75}, {-1, -1, -1}), number(3, 3, 2));
  const Vector3 aim{0, 2.25, 3.75}, from{-1e6, 7e5, -4e5};
  EXPECT_EQ(hit(renderer, from, {aim[0] - from[0], aim[1] - from[1], aim[2] - from[2]}),
            number(0, 2, 3));
}

TEST(Rays, GrazingAFace) {
  const auto volume =
      make_volume({1000, 4, 3}, [](auto x, auto y, auto) { return y == 1 ? 1 + x / 10 : 0; });
  const ReferenceRenderer renderer(volume, 16, 1);
  // Falls from y = 2.5 by 1 voxel over 1000: meets the layer's top (y = 2) at x = 500.
  EXPECT_EQ(hit(renderer, {0.25, 2.5 - 1e-4, 1.5}, {1, -1e-3, 0}), 51u);
  EXPECT_EQ(hit(renderer, {0, 2.0 + 1e-9, 1.5}, {1, 0, 0}), kNoLabel);
  EXPECT_EQ(hit(renderer, {0, 2.0 - 1e-9, 1.5}, {1, 0, 0}), 1u);
}

TEST(Rays, LongVolumes) {
  const auto volume = make_volume(
      {16384, 3, 2},
      [](auto x, auto y, auto) { return x == 16383 ? 60000 : (y == 1 && x == 9001 ? 77 : 0); },
      volumes::VoxelType::kU16);
  for (const std::uint32_t brick : {16u, 64u}) {
    const ReferenceRenderer renderer(volume, brick, 2);
    EXPECT_EQ(hit(renderer, {-1, 0.5, 0.5}, {1, 0, 0}), 60000u);
    EXPECT_EQ(hit(renderer, {-1, 1.5, 0.5}, {1, 0, 0}), 77u);
    EXPECT_EQ(hit(renderer, {16383, 1.5, 0.5}, {-1, 0, 0}), 77u);
    // From one end's corner to the other's.
    EXPECT_EQ(hit(renderer, {0.5, 0.1, 0.1}, {16383, 2.8, 1.8}), 77u);
    EXPECT_EQ(hit(renderer, {0.5, 0.1, 0.1}, {16383, 0.8, 1.8}), 60000u);
  }
}

TEST(Rays, LabelsOfEveryWidth) {
  const std::uint64_t label = 0xFEDCBA9876543210u;
  for (const auto type : {volumes::VoxelType::kU8, volumes::VoxelType::kU16,
                          volumes::VoxelType::kU32, volumes::VoxelType::kU64}) {
    const auto volume = make_volume(
        {3, 3, 3}, [&](auto x, auto, auto) { return x == 1 ? label : 0; }, type);
    const unsigned bits = 8 * static_cast<unsigned>(volumes::size_of(type));
    EXPECT_EQ(hit(ReferenceRenderer(volume, 16, 1), {-1, 1.5, 1.5}, {1, 0, 0}),
              bits == 64 ? label : label & ((1ull << bits) - 1));
  }
}

/// The first visible cell by testing every cell of every brick against the ray, cut to the volume.
std::uint64_t first_by_brute_force(const LabelBricks& bricks, const View& view,
                                   const ReferenceRenderer::Ray& ray) {
  const volumes::Extent &grid = bricks.grid(), &extent = bricks.info().extent;
  double best = kInfinity;
  std::uint64_t label = kNoLabel;
  for (std::uint64_t brick = 0; brick < grid.voxels(); ++brick) {
    const unsigned level = view.level_of(brick);
    if (level == kInvisibleBrick) continue;
    const std::uint64_t edge = 1u << level, b = bricks.brick();
    const volumes::Coordinate low{brick % grid.x * b, brick / grid.x % grid.y * b,
                                  brick / (grid.x * grid.y) * b};
    for (std::uint64_t z = low.z; z < std::min(low.z + b, extent.z); z += edge) {
      for (std::uint64_t y = low.y; y < std::min(low.y + b, extent.y); y += edge) {
        for (std::uint64_t x = low.x; x < std::min(low.x + b, extent.x); x += edge) {
          const std::uint64_t here =
              bricks.level(level).label({x >> level, y >> level, z >> level});
          if (view.material(here).a == 0) continue;
          const Vector3 from{double(x), double(y), double(z)};
          const Vector3 to{double(std::min(x + edge, extent.x)),
                           double(std::min(y + edge, extent.y)),
                           double(std::min(z + edge, extent.z))};
          double enter = 0, leave = kInfinity;
          for (std::size_t a = 0; a < 3; ++a) {
            const double t0 = (from[a] - ray.origin[a]) / ray.direction[a],
                         t1 = (to[a] - ray.origin[a]) / ray.direction[a];
            enter = std::max(enter, std::min(t0, t1));
            leave = std::min(leave, std::max(t0, t1));
          }
          if (enter < leave && enter < best) best = enter, label = here;
        }
      }
    }
  }
  return label;
}

TEST(Rays, AgreeWithBruteForceOnRandomVolumesAtMixedLevels) {
  std::mt19937_64 random(20240611);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::uint64_t hits = 0, misses = 0;
  std::array<std::uint64_t, 5> levels_seen{};
  for (const volumes::Extent extent : {volumes::Extent{37, 21, 50}, {16, 48, 17}, {5, 64, 33}}) {
    for (const double density : {0.004, 0.05, 0.6}) {
      // Blocks of 2 or 3 voxels, so that something survives at the coarser levels.
      const std::uint64_t grain = 2 + random() % 2, seed = random();
      const auto volume = make_volume(extent, [&](auto x, auto y, auto z) {
        std::mt19937_64 own(seed ^
                            (x / grain * 73856093 + y / grain * 19349663 + z / grain * 83492791));
        own.discard(3);
        const std::uint64_t value = own();
        return static_cast<double>(value >> 11) * 0x1p-53 < density ? 1 + value % 200 : 0;
      });
      const LabelBricks bricks(volume, 16, 2);
      for (const double bias : {-40.0, 0.0, 40.0}) {
        Scene scene = plain_scene();
        scene.height = 64;
        scene.lod_bias = bias;
        const Camera camera{{0.4, 0.3, 0.55}, {0, 0, 0}, {0, 1, 0}, bias == 0 ? 150.0 : 45.0};
        const View view(bricks, scene, camera, 1);
        for (std::uint64_t brick = 0; brick < bricks.grid().voxels(); ++brick)
          if (view.level_of(brick) != kInvisibleBrick) ++levels_seen[view.level_of(brick)];
        for (int i = 0; i < 300; ++i) {
          const auto point = [&](double margin) {
            return Vector3{(unit() * (1 + 2 * margin) - margin) * extent.x,
                           (unit() * (1 + 2 * margin) - margin) * extent.y,
                           (unit() * (1 + 2 * margin) - margin) * extent.z};
          };
          const Vector3 from = point(i % 2 == 0 ? 1 : 0), to = point(0.1);
          const ReferenceRenderer::Ray ray{from,
                                           {to[0] - from[0], to[1] - from[1], to[2] - from[2]}};
          const std::uint64_t truth = first_by_brute_force(bricks, view, ray);
          Walk walk(view, ray);
          std::uint64_t found = kNoLabel;
          for (; !walk.at_end() && found == kNoLabel; walk.next())
            if (walk.visible_brick() && view.material(walk.label()).a > 0) found = walk.label();
          ASSERT_EQ(found, truth) << "ray " << i << " bias " << bias;
          ++(truth == kNoLabel ? misses : hits);
        }
      }
    }
  }
  EXPECT_GT(hits, 1000u);
  EXPECT_GT(misses, 500u);
  for (const std::uint64_t seen : levels_seen) EXPECT_GT(seen, 0u);
}

TEST(Rays, VisitConnectedCellsInOrderOfTime) {
  const auto volume = make_volume(
      {50, 40, 45}, [](auto x, auto y, auto z) { return 1 + (x / 3 + y / 5 + z / 4) % 7; });
  const LabelBricks bricks(volume, 16, 1);
  Scene scene = plain_scene();
  scene.height = 40;
  scene.lod_bias = 0.5;
  const View view(bricks, scene, {{0.5, 0.4, 0.6}, {0, 0, 0}, {0, 1, 0}, 90}, 1);
  std::mt19937_64 random(5);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (int i = 0; i < 500; ++i) {
    const Vector3 direction{unit() - 0.5, unit() - 0.5, unit() - 0.5};
    double before = 0;
    int steps = 0;
    for (Walk walk(view, {{unit() * 50, unit() * 40, unit() * 45}, direction}); !walk.at_end();
         walk.next(), ++steps) {
      ASSERT_GE(walk.t(), before);
      before = walk.t();
    }
    EXPECT_GT(steps, 0);
    EXPECT_LE(steps, 50 + 40 + 45);
  }
}

}  // namespace
}  // namespace cvr::gpu
