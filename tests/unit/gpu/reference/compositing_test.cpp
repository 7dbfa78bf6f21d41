// Materials, compositing and shading against figures worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/gpu/reference/small_volumes.hpp"

namespace cvr::gpu {
namespace {

constexpr double kHalf = 128 / 255.0;  ///< an opacity of 0.5 in 8 bits

/// Label 1: red, half; 2: green, half; 3: blue, opaque; 4: nearly nothing gets through; 0 and the
/// rest invisible.
Scene coloured_scene() {
  Scene scene = plain_scene();
  scene.materials = {{.first = 1, .last = 1, .opacity = 0.5, .colour = {{255, 0, 0}}},
                     {.first = 2, .last = 2, .opacity = 0.5, .colour = {{0, 255, 0}}},
                     {.first = 3, .last = 3, .colour = {{0, 0, 255}}},
                     {.first = 4, .last = 4, .opacity = 0.9, .colour = {{0, 0, 0}}}};
  scene.background = {51, 102, 153};
  scene.ambient = 1;
  return scene;
}

/// The one pixel of a row of labels, seen along x.
Image see_row(const std::vector<unsigned>& labels, const Scene& scene, std::uint32_t brick = 16) {
  const auto volume =
      make_volume({labels.size(), 1, 1}, [&](auto x, auto, auto) { return labels[x]; });
  const ReferenceRenderer renderer(volume, brick, 1);
  return renderer.render(scene, look(volume.info(), {-20, 0.5, 0.5}, {0, 0.5, 0.5}, {0, 1, 0}));
}

void expect_colour(const Image& image, double r, double g, double b) {
  EXPECT_NEAR(image.colour[0], r, 1e-6);
  EXPECT_NEAR(image.colour[1], g, 1e-6);
  EXPECT_NEAR(image.colour[2], b, 1e-6);
}

TEST(Compositing, BackgroundWhereNothingIs) {
  const Image image = see_row({0, 9, 0}, coloured_scene());
  expect_colour(image, 0.2, 0.4, 0.6);
  EXPECT_EQ(image.labels[0], kNoLabel);
  EXPECT_EQ(image.complete[0], 1);
}

TEST(Compositing, BlendsFrontToBack) {
  const Image image = see_row({0, 1, 2, 3}, coloured_scene());
  expect_colour(image, kHalf, (1 - kHalf) * kHalf, (1 - kHalf) * (1 - kHalf));
  EXPECT_EQ(image.labels[0], 1u);
  const Image open = see_row({2, 0}, coloured_scene());
  expect_colour(open, (1 - kHalf) * 0.2, kHalf + (1 - kHalf) * 0.4, (1 - kHalf) * 0.6);
}

TEST(Compositing, OneVisitBlendsOnce) {
  const double once = kHalf + (1 - kHalf) * 0.2, twice = 1 - (1 - kHalf) * (1 - kHalf) * 0.8;
  EXPECT_NEAR(see_row({1, 1, 1, 1}, coloured_scene()).colour[0], once, 1e-6);
  EXPECT_NEAR(see_row(std::vector<unsigned>(40, 1), coloured_scene()).colour[0], once, 1e-6)
      << "also across bricks";
  EXPECT_NEAR(see_row({1, 0, 1}, coloured_scene()).colour[0], twice, 1e-6)
      << "an invisible label in between";
  std::vector<unsigned> apart(48, 0);
  apart.front() = apart.back() = 1;
  EXPECT_NEAR(see_row(apart, coloured_scene()).colour[0], twice, 1e-6)
      << "an invisible brick in between";
  std::vector<unsigned> at_borders(48, 0);
  at_borders[15] = at_borders[32] = 1;
  EXPECT_NEAR(see_row(at_borders, coloured_scene()).colour[0], twice, 1e-6)
      << "and nothing but that brick";
}

TEST(Compositing, EndsWhenNothingGetsThrough) {
  // Opacity 230 / 255: T = 0.098, 0.0096, 0.00094 < 1 / 256. After the third visit the ray ends and
  // the blue is not seen.
  const double t = 25 / 255.0;
  expect_colour(see_row({4, 0, 4, 3}, coloured_scene()), 0, 0, t * t);
  expect_colour(see_row({4, 0, 4, 0, 4, 3}, coloured_scene()), 0.2 * t * t * t, 0.4 * t * t * t,
                0.6 * t * t * t);
}

TEST(Compositing, SurfacesBeginAtOpacity250) {
  Scene scene = coloured_scene();
  scene.ambient = 0;
  scene.light = {1, 0, 0};  // behind the face that is seen: a surface is black
  scene.materials = {{.first = 1, .last = 1, .opacity = 250 / 255.0, .colour = {{255, 255, 255}}},
                     {.first = 2, .last = 2, .opacity = 249 / 255.0, .colour = {{255, 255, 255}}}};
  EXPECT_EQ(see_row({1}, scene).colour[0], 0);
  EXPECT_NEAR(see_row({2}, scene).colour[0], 249 / 255.0 + 6 / 255.0 * 0.2, 1e-6);
}

TEST(Shading, LambertOnEachFace) {
  const auto volume =
      make_volume({3, 3, 3}, [](auto x, auto y, auto z) { return x == 1 && y == 1 && z == 1; });
  const ReferenceRenderer renderer(volume, 16, 1);
  Scene scene = plain_scene();
  scene.light = {0.2, -0.6, 1.4};
  scene.ambient = 0.25;
  const double size = std::sqrt(0.2 * 0.2 + 0.6 * 0.6 + 1.4 * 1.4);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vector3 eye{1.5, 1.5, 1.5}, up{0, 0, 0};
      eye[axis] += 10 * side;
      up[(axis + 1) % 3] = 1;
      const Image image = renderer.render(scene, look(volume.info(), eye, {1.5, 1.5, 1.5}, up));
      const double expected = 0.25 + 0.75 * std::max(0.0, side * scene.light[axis] / size);
      EXPECT_NEAR(image.colour[0], expected, 1e-6) << "axis " << axis << " side " << side;
    }
  }
}

TEST(Shading, RayThatBeginsInAnOpaqueCell) {
  const auto volume = make_volume({5, 5, 5}, [](auto, auto, auto) { return 1; });
  const ReferenceRenderer renderer(volume, 16, 1);
  Scene scene = plain_scene();
  scene.light = {0, -1, 0};
  scene.ambient = 0.2;
  const Camera camera =
      look(volume.info(), {2.3, 2.3, 2.3}, {2.5, 2.9, 2.5}, {0, 0, 1});  // |d| is largest along y
  for (const Shading shading : kShadings) {
    scene.shading = shading;
    EXPECT_NEAR(renderer.render(scene, camera).colour[0], 1, 1e-6)
        << "lit, and no secondary ray is cast";
  }
}

/// A floor (y = 0) with a roof above a part of it.
volumes::Volume roofed(unsigned roof_label) {
  return make_volume({40, 12, 40}, [=](auto x, auto y, auto z) -> unsigned {
    if (y == 0) return 3;
    return y == 10 && x >= 8 && x < 16 && z >= 8 && z < 32 ? roof_label : 0;
  });
}

/// The red channel of the floor at a place, seen aslant along z (so that the roof is not in the
/// way).
double floor_at(unsigned roof_label, double x, double z, Scene scene) {
  const auto volume = roofed(roof_label);
  scene.materials[2].colour = {{255, 255, 255}};
  const ReferenceRenderer renderer(volume, 16, 1);
  return renderer.render(scene, look(volume.info(), {x, 5, z + 40}, {x, 1, z}, {0, 1, 0}))
      .colour[0];
}

TEST(Shading, ShadowsOfOpaqueAndSemiTransparentLabels) {
  Scene scene = coloured_scene();
  scene.ambient = 0.25;
  scene.shading = Shading::kShadow;
  scene.light = {
      -1, 1, 0};  // the roof (8 .. 16, 9 or 10 above the floor) throws its shadow on x = 17 .. 26
  const double lambert = std::sqrt(0.5), lit = 0.25 + 0.75 * lambert, dark = 0.25;
  EXPECT_NEAR(floor_at(3, 21.5, 20.5, scene), dark, 1e-6);
  EXPECT_NEAR(floor_at(1, 21.5, 20.5, scene), 0.25 + 0.75 * lambert * (1 - kHalf), 1e-6);
  EXPECT_NEAR(floor_at(9, 21.5, 20.5, scene), lit, 1e-6) << "an invisible roof";
  EXPECT_NEAR(floor_at(3, 16.8, 20.5, scene), lit, 1e-6);
  EXPECT_NEAR(floor_at(3, 26.2, 20.5, scene), lit, 1e-6);
  EXPECT_NEAR(floor_at(3, 17.2, 20.5, scene), dark, 1e-6);
  EXPECT_NEAR(floor_at(3, 25.8, 20.5, scene), dark, 1e-6);
  scene.shading = Shading::kLocal;
  EXPECT_NEAR(floor_at(3, 21.5, 20.5, scene), lit, 1e-6);
}

/// Share of the cosine-weighted hemisphere of a floor element that a wall hides which stands at
/// distance c, begins beside it and goes on for b, a high (the view factor of a rectangle at right
/// angles to the element's plane).
double hidden_by_wall(double a, double b, double c) {
  const double x = a / b, y = c / b, root = std::sqrt(x * x + y * y);
  return (std::atan(1 / y) - y / root * std::atan(1 / root)) / (2 * std::numbers::pi);
}

volumes::Volume floor_beside_a_cube() {
  return make_volume({64, 33, 64}, [](auto x, auto y, auto z) {
    return y == 0 || (x >= 24 && x < 40 && z >= 24 && z < 40 && y <= 16);
  });
}

Scene lit_from_above() {
  Scene scene = plain_scene();
  scene.shading = Shading::kAo;
  scene.light = {0, 1, 0};
  scene.ao_distance = 2;
  return scene;
}

TEST(Shading, AmbientOcclusionOfAFloorBesideACube) {
  const volumes::Volume volume = floor_beside_a_cube();
  const ReferenceRenderer renderer(volume, 16, 2);
  Scene scene = lit_from_above();
  constexpr std::uint32_t kFrames = 20000;
  for (const double c : {1.5, 6.5, 20.5}) {
    const Vector3 place{40 + c, 1, 28.5};  // 4.5 and 11.5 to the ends of the wall
    const Camera camera = look(volume.info(), {place[0], 30, place[2]}, place, {0, 0, 1});
    const double open = 1 - hidden_by_wall(16, 4.5, c) - hidden_by_wall(16, 11.5, c);
    const double sigma = std::sqrt(open * (1 - open) / kFrames);
    EXPECT_NEAR(renderer.render(scene, camera, 0, kFrames).colour[0], open, 4 * sigma)
        << "distance " << c;
  }
  // Too short to reach the wall: nothing is hidden. Long enough: something is.
  const Camera camera = look(volume.info(), {46, 30, 28.5}, {46, 1, 28.5}, {0, 0, 1});
  scene.ao_distance = 5.9 / 64;
  EXPECT_FLOAT_EQ(renderer.render(scene, camera, 0, 2000).colour[0], 1);
  scene.ao_distance = 8.0 / 64;
  EXPECT_LT(renderer.render(scene, camera, 0, 2000).colour[0], 1);
}

TEST(Shading, RouletteKeepsTheMeanAndCastsFewerRays) {
  const volumes::Volume volume = floor_beside_a_cube();
  const ReferenceRenderer renderer(volume, 16, 2);
  Scene scene = lit_from_above();
  scene.ao_roulette = true;
  scene.materials = {{.first = 1, .last = 1, .colour = {{51, 153, 102}}}};
  const double probability = 0.6,
               open = 1 - hidden_by_wall(16, 4.5, 6.5) - hidden_by_wall(16, 11.5, 6.5);
  const Vector3 place{46.5, 1, 28.5};
  const Camera camera = look(volume.info(), {place[0], 30, place[2]}, place, {0, 0, 1});
  constexpr std::uint32_t kFrames = 20000;
  const Image mean = renderer.render(scene, camera, 0, kFrames);
  const double sigma = std::sqrt(open / probability * (1 - open * probability) / kFrames);
  EXPECT_NEAR(mean.colour[0], 0.2 * open, 4 * 0.2 * sigma);
  EXPECT_NEAR(mean.colour[1], 0.6 * open, 4 * 0.6 * sigma);
  std::uint32_t dark = 0;  // frames without a ray, or whose ray is hidden
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const float red = renderer.render(scene, camera, i).colour[0];
    if (red == 0)
      ++dark;
    else
      EXPECT_FLOAT_EQ(red, 0.2f / 0.6f);
  }
  EXPECT_NEAR(dark / 1000.0, 1 - probability * open, 0.07);
}

TEST(Shading, FramesAreTheMeanOfSingleFrames) {
  const auto volume = make_volume(
      {24, 20, 22}, [](auto x, auto y, auto z) { return (x * 7 + y * 5 + z * 3) % 11 < 3; });
  const ReferenceRenderer renderer(volume, 16, 2);
  Scene scene = plain_scene();
  scene.shading = Shading::kAo;
  scene.width = 24;
  scene.height = 16;
  const Camera camera{{0.8, 0.7, 1.2}, {0, 0, 0}, {0, 1, 0}, 45};
  const Image both = renderer.render(scene, camera, 3, 2),
              third = renderer.render(scene, camera, 3), fourth = renderer.render(scene, camera, 4);
  EXPECT_FALSE(compare(third, fourth).identical());
  for (std::size_t i = 0; i < both.colour.size(); ++i)
    ASSERT_NEAR(both.colour[i], (third.colour[i] + fourth.colour[i]) / 2, 1e-6);
  EXPECT_EQ(both.labels, third.labels);
}

TEST(Shading, AnisotropicVoxelsKeepWorldAngles) {
  // Voxels twice as long along x: light at 45 degrees in the world makes a shadow half as many
  // voxels long.
  auto volume = roofed(3);
  volume.info().voxel_size = {2, 1, 1};
  Scene scene = coloured_scene();
  scene.materials[2].colour = {{255, 255, 255}};
  scene.ambient = 0.25;
  scene.shading = Shading::kShadow;
  scene.light = {-1, 1, 0};
  const ReferenceRenderer renderer(volume, 16, 1);
  const auto floor_at_voxel = [&](double x) {
    const double size = world_size(volume.info());
    const auto place = [&](double y, double z) {
      return Vector3{(x - 20) * 2 / size, (y - 6) / size, (z - 20) / size};
    };
    return renderer.render(scene, {place(5, 60.5), place(1, 20.5), {0, 1, 0}, 1e-3}).colour[0];
  };
  const double lit = 0.25 + 0.75 * std::sqrt(0.5);  // the shadow: 8 + 4.5 .. 16 + 5
  EXPECT_NEAR(floor_at_voxel(12.4), lit, 1e-6);
  EXPECT_NEAR(floor_at_voxel(12.6), 0.25, 1e-6);
  EXPECT_NEAR(floor_at_voxel(20.9), 0.25, 1e-6);
  EXPECT_NEAR(floor_at_voxel(21.1), lit, 1e-6);
}

}  // namespace
}  // namespace cvr::gpu
