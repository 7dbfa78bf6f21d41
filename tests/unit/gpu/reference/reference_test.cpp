// Cameras, levels of detail, near-ties, the work that a picture needs, and that threads and caches
// change nothing.
#include "gpu/reference/reference.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "gpu/reference/view.hpp"
#include "tests/unit/gpu/reference/small_volumes.hpp"

namespace cvr::gpu {
namespace {

TEST(Reference, PrimaryRaysOfAPinhole) {
  auto volume = make_volume({10, 20, 40}, [](auto, auto, auto) { return 1; });
  volume.info().voxel_size = {4, 2, 2};  // the world is 20 x 20 x 40
  const ReferenceRenderer renderer(volume, 16, 1);
  Scene scene = plain_scene();
  scene.width = 4;
  scene.height = 2;
  const Camera camera{{0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 90};
  const auto ray = renderer.primary_ray(scene, camera, 3, 0);
  const Vector3 origin{5, 10, 100},
      direction{1.5 / 2, 0.5, -1};  // right 0.75 * 2, up 0.5, forward -z
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(ray.origin[axis], origin[axis], 1e-12);
    EXPECT_NEAR(ray.direction[axis], direction[axis], 1e-12);
  }
  const auto left_below = renderer.primary_ray(scene, camera, 0, 1);
  EXPECT_NEAR(left_below.direction[0], -1.5 / 2, 1e-12);
  EXPECT_NEAR(left_below.direction[1], -0.5, 1e-12);
}

/// The level of the brick at the origin of a volume of 16^3 for a footprint of its distance.
unsigned level_for(double footprint, double bias = 0) {
  const auto volume = make_volume({16, 16, 16}, [](auto, auto, auto) { return 1; });
  const LabelBricks bricks(volume, 16, 1);
  Scene scene = plain_scene();
  scene.width = scene.height = 100;
  scene.lod_bias = bias;
  // The eye is 2 * 16 from the brick's centre, so its distance is 48; tan(f / 2) is what makes the
  // footprint.
  const double fov = 2 * std::atan(footprint * 100 / 2 / 48) * 180 / std::numbers::pi;
  return View(bricks, scene, {{0, 0, 2}, {0, 0, 0}, {0, 1, 0}, fov}, 1).level_of(0);
}

TEST(Reference, LevelsOfDetailFollowTheFootprint) {
  EXPECT_EQ(level_for(0.01), 0u);
  EXPECT_EQ(level_for(1.999), 0u);
  EXPECT_EQ(level_for(2.001), 1u);
  EXPECT_EQ(level_for(3.999), 1u);
  EXPECT_EQ(level_for(4.001), 2u);
  EXPECT_EQ(level_for(8.001), 3u);
  EXPECT_EQ(level_for(16.001), 4u);
  EXPECT_EQ(level_for(300), 4u) << "the coarsest level of a brick";
  EXPECT_EQ(level_for(2.001, 1), 2u);
  EXPECT_EQ(level_for(2.001, -1), 0u);
  EXPECT_EQ(level_for(3, 0.5), 2u) << "3 * sqrt(2) > 4";
}

TEST(Reference, LevelsReachBeyondVolumesThatEndInABrick) {
  // The centre of the full cube counts: a sliver of a brick has the level of the whole one.
  const auto volume = make_volume({17, 16, 16}, [](auto, auto, auto) { return 1; });
  const LabelBricks bricks(volume, 16, 1);
  Scene scene = plain_scene();
  scene.height = 100;
  scene.lod_bias = 0;
  // In the world the eye is at (8.5 - 17, 8, 8); the centres lie at x = 8 and 24: distances 16.5
  // and 32.5, plus 16.
  const double fov =
      2 * std::atan(0.5 * 100 * 4.0 / 40) * 180 / std::numbers::pi;  // footprint 4 at distance 40
  const View view(bricks, scene, {{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, fov}, 1);
  EXPECT_EQ(view.level_of(0), 1u);  // 32.5 of 40
  EXPECT_EQ(view.level_of(1), 2u);  // 48.5 of 40
  // The sliver's own centre, at x = 16.5, would be at distance 41 and give level 1 where 4 is the
  // footprint at 45.
  const double narrower = 2 * std::atan(0.5 * 100 * 4.0 / 45) * 180 / std::numbers::pi;
  EXPECT_EQ(View(bricks, scene, {{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, narrower}, 1).level_of(1), 2u);
}

TEST(Reference, DistancesAreThoseOfTheWorld) {
  auto volume = make_volume({16, 16, 16}, [](auto, auto, auto) { return 1; });
  volume.info().voxel_size = {3, 3, 9};  // the world is 16 x 16 x 48
  const LabelBricks bricks(volume, 16, 1);
  Scene scene = plain_scene();
  scene.height = 100;
  scene.lod_bias = 0;
  // From one longest edge away: 48 + 16 in the world.
  const auto level = [&](double distance) {
    const double fov = 2 * std::atan(0.5 * 100 * 4.0 / distance) * 180 / std::numbers::pi;
    return View(bricks, scene, {{1, 0, 0}, {0, 0, 0}, {0, 1, 0}, fov}, 1).level_of(0);
  };
  EXPECT_EQ(level(63.9), 2u);
  EXPECT_EQ(level(64.1), 1u);
}

TEST(Reference, CoarseLevelsShowThePyramid) {
  // A wall of one voxel at x = 0 ties with the emptiness behind it and is first in order: level l
  // makes it 2^l thick.
  const auto volume = make_volume({16, 16, 16}, [](auto x, auto, auto) { return x == 0 ? 7 : 0; });
  const ReferenceRenderer renderer(volume, 16, 1);
  for (unsigned level = 0; level <= 4; ++level) {
    Scene scene = plain_scene();
    scene.height = 100;
    scene.lod_bias = 0;
    const double fov = 2 * std::atan(1.4 * (1u << level) * 100 / 2 / 48) * 180 / std::numbers::pi;
    const Camera camera{{0, 0, 2}, {0, 0, 0}, {0, 1, 0}, fov};
    const double edge = 1u << level;
    EXPECT_EQ(renderer.trace(scene, camera, {{edge - 0.01, 30, 8.5}, {0, -1, 0}}), 7u);
    EXPECT_EQ(renderer.trace(scene, camera, {{edge + 0.01, 30, 8.5}, {0, -1, 0}}), kNoLabel);
  }
}

TEST(Reference, NearTiesAreNearAndTies) {
  const auto volume =
      make_volume({8, 8, 8}, [](auto x, auto, auto z) { return z == 7 ? (x < 4 ? 1 : 2) : 3; });
  const ReferenceRenderer renderer(volume, 16, 1);
  const Scene scene = plain_scene();
  const auto at = [&](double x, double y) {
    return look(volume.info(), {x, y, 30}, {x, y, 8}, {0, 1, 0});
  };
  const auto tie = [&](double x, double y, std::uint64_t other) {
    return renderer.is_near_tie(scene, at(x, y), 0, 0, other);
  };
  EXPECT_TRUE(tie(4 - 5e-5, 4.5, 2));
  EXPECT_TRUE(tie(4 + 5e-5, 4.5, 1));
  EXPECT_TRUE(tie(4 - 1e-7, 4.5, 2));
  EXPECT_FALSE(tie(4 - 2e-4, 4.5, 2));
  EXPECT_FALSE(tie(4 - 5e-5, 4.5, 3)) << "the label behind";
  EXPECT_FALSE(tie(4 - 5e-5, 4.5, kNoLabel));
  EXPECT_TRUE(tie(2.5, 8 - 5e-5, kNoLabel)) << "the edge of the volume";
  EXPECT_TRUE(tie(2.5, 8 + 5e-5, 1)) << "from outside";
  EXPECT_FALSE(tie(2.5, 8 + 2e-4, 1));
  EXPECT_TRUE(tie(2.5, 4.5, 1)) << "its own label";
}

TEST(Reference, ChecksLabelImages) {
  const auto volume = make_volume({8, 8, 8}, [](auto x, auto, auto) { return x < 4 ? 1 : 2; });
  const ReferenceRenderer renderer(volume, 16, 1);
  Scene scene = plain_scene();
  scene.width = 3;
  // Pixels are 2 voxels wide; the middle one looks at the border between the labels.
  const Camera camera = look(volume.info(), {4 + 2e-5, 4.5, 8 + 10}, {4 + 2e-5, 4.5, 8}, {0, 1, 0},
                             2 * std::atan(0.1) * 180 / std::numbers::pi);
  const Image truth = renderer.render(scene, camera);
  EXPECT_EQ(truth.labels, (std::vector<std::uint64_t>{1, 2, 2}));
  Image found = truth;
  found.labels = {2, 1, 2};
  const LabelCheck check = check_labels(renderer, scene, camera, truth, found);
  EXPECT_EQ(check.pixels, 3u);
  EXPECT_EQ(check.differing, 2u);
  EXPECT_EQ(check.near_ties, 1u);
  EXPECT_EQ(check_labels(renderer, scene, camera, truth, truth).differing, 0u);
}

TEST(Reference, CountsTheWorkOfAPicture) {
  // Three bricks in a row: the first without a visible label, the others with one at their ends.
  const auto volume = make_volume({48, 16, 16}, [](auto x, auto, auto) {
    return x == 31 ? 1 : x == 47 ? 2 : 0;
  });
  const ReferenceRenderer renderer(volume, 16, 1);
  Scene scene = plain_scene();
  const Camera camera = look(volume.info(), {-5, 8.5, 8.5}, {0, 8.5, 8.5}, {0, 1, 0});
  NeededWork needed;
  renderer.render(scene, camera, needed);
  EXPECT_EQ(needed.visits, 16u);
  EXPECT_EQ(needed.distinct_cells, 16u);
  EXPECT_EQ(needed.distinct_bricks, 1u);

  scene.materials[1].opacity = 0.5;
  renderer.render(scene, camera, needed);
  EXPECT_EQ(needed.visits, 32u);
  EXPECT_EQ(needed.distinct_bricks, 2u);

  scene.width = scene.height = 4;  // 16 rays within one row of cells
  renderer.render(scene, camera, needed);
  EXPECT_EQ(needed.visits, 16u * 32);
  EXPECT_EQ(needed.distinct_cells, 32u);

  scene.width = scene.height = 1;
  scene.lod_bias =
      40;  // at the coarsest level per brick is one cell, and its label that of its majority: nothing
  renderer.render(scene, camera, needed);
  EXPECT_EQ(needed.visits, 2u);
  EXPECT_EQ(needed.distinct_cells, 2u);
}

TEST(Reference, SecondaryRaysCountAsWork) {
  const auto volume = make_volume({16, 16, 16}, [](auto x, auto, auto) { return x == 8; });
  const ReferenceRenderer renderer(volume, 16, 1);
  Scene scene = plain_scene();
  scene.light = {-1, 0, 0};
  const Camera camera = look(volume.info(), {-5, 8.5, 8.5}, {0, 8.5, 8.5}, {0, 1, 0});
  NeededWork local, shadow;
  renderer.render(scene, camera, local);
  scene.shading = Shading::kShadow;
  renderer.render(scene, camera, shadow);
  EXPECT_EQ(local.visits, 9u);
  EXPECT_EQ(shadow.visits, 17u) << "back through the eight cells in front of the wall";
  EXPECT_EQ(shadow.distinct_cells, 9u);
}

TEST(Reference, ThreadsAndBricksOfInvisibleLabelsChangeNothing) {
  const auto volume = make_volume(
      {70, 50, 60}, [](auto x, auto y, auto z) { return (x / 9 + y / 7 * 3 + z / 8 * 5) % 13; });
  Scene scene = plain_scene();
  scene.materials = {{.first = 3, .last = 4}, {.first = 7, .last = 7, .opacity = 0.3}};
  scene.width = 96;
  scene.height = 54;
  scene.shading = Shading::kShadow;
  const Camera camera{{0.9, 0.6, 1.1}, {0, 0, 0}, {0, 1, 0}, 45};
  const ReferenceRenderer one(volume, 16, 1), four(volume, 16, 4);
  const Image image = one.render(scene, camera);
  EXPECT_TRUE(compare(image, four.render(scene, camera)).identical());
  NeededWork needed;
  EXPECT_TRUE(compare(image, four.render(scene, camera, needed)).identical());
  // At the finest level the size of bricks is of no matter.
  EXPECT_TRUE(compare(image, ReferenceRenderer(volume, 64, 2).render(scene, camera)).identical());
  // A changed scene is not mistaken for the one before.
  scene.materials[0].opacity = 0.5;
  EXPECT_FALSE(compare(image, one.render(scene, camera)).identical());
}

}  // namespace
}  // namespace cvr::gpu
