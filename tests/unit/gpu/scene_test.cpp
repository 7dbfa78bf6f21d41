// Scenes: paths, materials, spaces, and the files that they are read from.
#include "gpu/scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "experiments/config/scene_file.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "volumes/error.hpp"

namespace cvr::gpu {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST(CameraPaths, PassThroughTheirKeysAtEqualSteps) {
  std::vector<Camera> keys;
  for (const double x : {0.0, 1.0, 5.0, 2.0, -3.0})
    keys.push_back({{x, x * x, 2}, {0, x, 0}, {0, 1, 0}, 30 + x});
  const CameraPath path(keys);
  for (std::size_t i = 0; i < keys.size(); ++i)
    EXPECT_EQ(path.at(static_cast<double>(i) / 4), keys[i]);
  EXPECT_EQ(path.at(-1), keys.front());
  EXPECT_EQ(path.at(2), keys.back());
  // Halfway between the second and the third key: (-a + 9 b + 9 c - d) / 16.
  EXPECT_NEAR(path.at(0.375).eye[0], (-0.0 + 9 * 1 + 9 * 5 - 2) / 16, 1e-12);
  EXPECT_NEAR(path.at(0.375).vertical_fov_degrees, 30 + 52.0 / 16, 1e-12);
  // No jump and no kink at a key.
  const double before = path.at(0.5).eye[0] - path.at(0.5 - 1e-6).eye[0],
               after = path.at(0.5 + 1e-6).eye[0] - path.at(0.5).eye[0];
  EXPECT_NEAR(before, after, 1e-9);
}

TEST(CameraPaths, OfOneAndOfTwoKeys) {
  const Camera a{{1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 40}, b{{3, 2, 7}, {0, 1, 0}, {0, 1, 0}, 60};
  EXPECT_EQ(CameraPath({a}).at(0.7), a);
  const Camera quarter = CameraPath({a, b}).at(0.25);
  EXPECT_NEAR(quarter.eye[0], 1.5, 1e-12);
  EXPECT_NEAR(quarter.eye[2], 4, 1e-12);
  EXPECT_NEAR(quarter.target[1], 0.25, 1e-12);
  EXPECT_NEAR(quarter.vertical_fov_degrees, 45, 1e-12);
}

TEST(CameraPaths, KeepTheFieldOfViewLegal) {
  const auto key = [](double fov) { return Camera{{0, 0, 2}, {0, 0, 0}, {0, 1, 0}, fov}; };
  const CameraPath path({key(179), key(179), key(0.01), key(0.01), key(179), key(179)});
  for (int i = 0; i <= 1000; ++i) {
    EXPECT_GT(path.at(i / 1000.0).vertical_fov_degrees, 0);
    EXPECT_LT(path.at(i / 1000.0).vertical_fov_degrees, 180);
  }
}

/// A straight path of 101 frames whose eye is at x = number of the frame.
Scene straight(std::uint32_t frames, std::uint32_t parts) {
  Scene scene;
  scene.path =
      CameraPath({{{0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 45}, {{100, 0, 9}, {0, 0, 0}, {0, 1, 0}, 45}});
  scene.path_frames = 101;
  scene.frames = frames;
  scene.path_parts = parts;
  return scene;
}

std::vector<int> frames_of(const Scene& scene) {
  std::vector<int> numbers;
  for (std::uint32_t n = 0; n < scene.frames; ++n) {
    numbers.push_back(static_cast<int>(std::lround(scene.camera(n).eye[0])));
    EXPECT_NEAR(scene.camera(n).eye[0], numbers.back(), 1e-9);
  }
  return numbers;
}

TEST(CameraPaths, AreDrawnSpreadOrInPartsOfConsecutiveFrames) {
  EXPECT_EQ(frames_of(straight(5, 0)), (std::vector{0, 25, 50, 75, 100}));
  EXPECT_EQ(frames_of(straight(6, 3)), (std::vector{0, 1, 49, 50, 99, 100}));
  EXPECT_EQ(frames_of(straight(4, 1)), (std::vector{0, 1, 2, 3}));
  EXPECT_EQ(frames_of(straight(7, 3)), (std::vector{0, 1, 2, 49, 50, 51, 98}));
  EXPECT_EQ(frames_of(straight(9, 4)), (std::vector{0, 1, 2, 49, 50, 51, 98, 99, 100}))
      << "three parts of three frames are all there are";
  EXPECT_EQ(frames_of(straight(3, 9)), (std::vector{0, 50, 100}));
  EXPECT_EQ(frames_of(straight(101, 4)), frames_of(straight(101, 0)));
  EXPECT_EQ(frames_of(straight(1, 1)), (std::vector{0}));
}

TEST(Materials, TheFirstRuleThatFitsCounts) {
  Scene scene;
  scene.materials = {
      {.first = 5, .last = 5, .opacity = 0},
      {.first = 3, .last = 9, .modulus = 2, .remainder = 1, .opacity = 0.5, .colour = {{1, 2, 3}}},
      {.first = 8, .last = UINT64_MAX, .colour = {{4, 5, 6}}}};
  EXPECT_EQ(scene.material(5).a, 0);
  EXPECT_EQ(scene.material(3), (Rgba{1, 2, 3, 128}));
  EXPECT_EQ(scene.material(9), (Rgba{1, 2, 3, 128}));
  EXPECT_EQ(scene.material(8), (Rgba{4, 5, 6, 255}));
  EXPECT_EQ(scene.material(UINT64_MAX), (Rgba{4, 5, 6, 255}));
  EXPECT_EQ(scene.material(4), Rgba{}) << "no rule fits: invisible";
  EXPECT_EQ(scene.material(0), Rgba{});
}

TEST(Materials, DerivedColoursAreBrightAndDistinct) {
  Scene scene;
  scene.materials = {{}};
  std::set<std::array<std::uint8_t, 3>> colours;
  std::array<unsigned, 6> sectors{};
  for (std::uint64_t label = 0; label < 1000; ++label) {
    const Rgba c = scene.material(label);
    const int most = std::max({c.r, c.g, c.b}), least = std::min({c.r, c.g, c.b});
    EXPECT_GE(most, 178);
    EXPECT_GE(most - least, 0.44 * most);
    EXPECT_LE(most - least, 0.86 * most);
    colours.insert({c.r, c.g, c.b});
    const unsigned middle = c.r == most   ? (c.g >= c.b ? 0 : 5)
                            : c.g == most ? (c.b >= c.r ? 2 : 1)
                                          : (c.r >= c.g ? 4 : 3);
    ++sectors[middle];
  }
  EXPECT_GT(colours.size(), 990u);
  for (const unsigned count : sectors) EXPECT_GT(count, 110u) << "all hues are used";
  EXPECT_EQ(scene.material(7), scene.material(7));
}

TEST(Shadings, HaveNames) {
  for (const Shading shading : kShadings) EXPECT_EQ(shading_from_name(name_of(shading)), shading);
  EXPECT_FALSE(shading_from_name("phong"));
}

TEST(Spaces, SceneSpaceFitsAnyVolume) {
  volumes::VolumeInfo info;
  info.extent = {100, 200, 50};
  info.voxel_size = {8, 4, 40};
  EXPECT_EQ(world_scale(info), (Vector3{2, 1, 10}));
  EXPECT_EQ(world_size(info), 500);
  EXPECT_EQ(world_from_scene(info, {0, 0, 0}), (Vector3{100, 100, 250}));
  EXPECT_EQ(world_from_scene(info, {0, 0, 0.5}), (Vector3{100, 100, 500}));
  EXPECT_EQ(world_from_scene(info, {-0.2, 0.2, -0.5}), (Vector3{0, 200, 0}));
}

class SceneFiles : public testing::Test {
 protected:
  Scene load(const std::string& text) {
    const std::string path = folder_ / "s.yaml";
    std::ofstream(path) << text;
    return experiments::load_scene(path);
  }
  /// The error without the folder's name.
  std::string error(const std::string& text) {
    try {
      load(text);
    } catch (const volumes::InputError& e) {
      const std::string what = e.what();
      const std::size_t at = what.find("s.yaml");
      return at == std::string::npos ? what : what.substr(at);
    }
    return "no error";
  }
  experiments::ScratchFolder folder_;
};

const std::string kRest = "title: T\nmaterials: [{}]\n";
const std::string kKeys = "keys: [{eye: [0, 0, 2]}]\n";

TEST_F(SceneFiles, EveryKey) {
  const Scene scene = load(R"(title: "A title"
keys:
  - {eye: [1, 2, 3], target: [0.5, 0, -1], up: [0, 0, 1], fov: 30}
  - {eye: [0, 0, 2]}
frames: 10
size: [320, 200]
materials:
  - {labels: 7, opacity: 0}
  - {labels: [2, 9], modulus: 3, remainder: 1, opacity: 0.25, colour: [10, 20, 30]}
  - {labels: all}
shading: shadow
light: [0, 2, 0]
ambient: 0.1
ao_distance: 0.3
ao_roulette: 1
lod_bias: -1.5
accumulate: 4
background: [1, 2, 3]
)");
  EXPECT_EQ(scene.name, "s");
  EXPECT_EQ(scene.title, "A title");
  ASSERT_EQ(scene.path.keys().size(), 2u);
  EXPECT_EQ(scene.path.keys()[0], (Camera{{1, 2, 3}, {0.5, 0, -1}, {0, 0, 1}, 30}));
  EXPECT_EQ(scene.path.keys()[1], (Camera{{0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 45}));
  EXPECT_EQ(scene.frames, 10u);
  EXPECT_EQ(scene.width, 320u);
  EXPECT_EQ(scene.height, 200u);
  const std::vector<MaterialRule> materials{
      {.first = 7, .last = 7, .opacity = 0}, {2, 9, 3, 1, 0.25, {{10, 20, 30}}}, {}};
  EXPECT_EQ(scene.materials, materials);
  EXPECT_EQ(scene.shading, Shading::kShadow);
  EXPECT_EQ(scene.light, (Vector3{0, 2, 0}));
  EXPECT_EQ(scene.ambient, 0.1);
  EXPECT_EQ(scene.ao_distance, 0.3);
  EXPECT_TRUE(scene.ao_roulette);
  EXPECT_EQ(scene.lod_bias, -1.5);
  EXPECT_EQ(scene.accumulate, 4u);
  EXPECT_EQ(scene.background, (std::array<std::uint8_t, 3>{1, 2, 3}));
}

TEST_F(SceneFiles, MistakesHaveAPlaceAndAHint) {
  EXPECT_THAT(error(kRest + kKeys + "shadnig: ao\n"),
              AllOf(StartsWith("s.yaml:4:1: expected one of the keys"),
                    HasSubstr("found 'shadnig' (did you mean 'shading'?)")));
  EXPECT_THAT(error(kRest + kKeys + "shading: shadw\n"),
              AllOf(StartsWith("s.yaml:4:10: expected local, shadow or ao"),
                    HasSubstr("did you mean 'shadow'")));
  EXPECT_THAT(error(kRest), HasSubstr("expected the key 'keys', found none"));
  EXPECT_THAT(error(kRest + "keys: []\n"),
              StartsWith("s.yaml:3:7: expected a list of cameras, found an empty list"));
  EXPECT_THAT(error("title: T\nmaterials: []\n" + kKeys),
              StartsWith("s.yaml:2:12: expected a list of materials"));
  EXPECT_THAT(error(kRest + kKeys + kKeys), HasSubstr("s.yaml:4:1: expected each key once"));
  EXPECT_THAT(error(kRest + "keys: [{target: [0, 0, 0]}]\n"),
              HasSubstr("s.yaml:3:8: expected the key 'eye'"));
  EXPECT_THAT(error(kRest + kKeys + "size: [10]\n"), HasSubstr("s.yaml:4:7: expected two sides"));
  EXPECT_THAT(error(kRest + kKeys + "size: [0, 10]\n"),
              HasSubstr("s.yaml:4:8: expected an integer in 1.."));
  EXPECT_THAT(error(kRest + kKeys + "background: [1, 2, 256]\n"),
              HasSubstr("s.yaml:4:20: expected an integer in 0..255"));
  EXPECT_THAT(error(kRest + kKeys + "ao_distance: 0\n"),
              HasSubstr("s.yaml:4:14: expected a number"));
  EXPECT_THAT(error(kRest + kKeys + "light: [0, 0, 0]\n"),
              HasSubstr("s.yaml:4:8: expected a vector other than"));
}

TEST_F(SceneFiles, NumbersThatAreNoneAreRefused) {
  for (const std::string bad : {"nan", ".nan", "inf", "-inf", ".inf", "1e999", "two", "''"}) {
    EXPECT_THAT(error(kRest + "keys: [{eye: [0, 0, " + bad + "]}]\n"),
                StartsWith("s.yaml:3:21: expected a number"))
        << bad;
    EXPECT_THAT(error(kRest + kKeys + "ambient: " + bad + "\n"),
                StartsWith("s.yaml:4:10: expected a number"))
        << bad;
  }
}

TEST_F(SceneFiles, CamerasThatSeeNothingAreRefused) {
  EXPECT_THAT(error(kRest + "keys: [{eye: [0, 0, 0]}]\n"),
              StartsWith("s.yaml:3:8: expected an eye away from its target"));
  EXPECT_THAT(error(kRest + "keys: [{eye: [0, 0, 2], up: [0, 0, 0]}]\n"),
              StartsWith("s.yaml:3:29: expected a vector other"));
  EXPECT_THAT(error(kRest + "keys: [{eye: [0, 0, 2], up: [0, 0, -3]}]\n"),
              StartsWith("s.yaml:3:8: expected an up that is not"));
  EXPECT_THAT(error(kRest + "keys: [{eye: [0, 0, 2], fov: 180}]\n"),
              StartsWith("s.yaml:3:30: expected a number"));
  EXPECT_THAT(error(kRest + "keys: [{eye: [0, 0, 2]}, {eye: [0, 0, -2]}]\nframes: 3\n"),
              HasSubstr("frame 1 of the path: expected an eye away from its target"));
}

TEST_F(SceneFiles, LabelsOfRules) {
  const auto rule = [&](const std::string& text) {
    return error("title: T\n" + kKeys + "materials: [{" + text + "}]\n");
  };
  EXPECT_EQ(rule("labels: 18446744073709551615"), "no error");
  EXPECT_THAT(rule("labels: every"),
              StartsWith("s.yaml:3:22: expected all, a label, or [FIRST, LAST], found 'every'"));
  EXPECT_THAT(rule("labels: -1"), StartsWith("s.yaml:3:22: expected all, a label"));
  EXPECT_THAT(rule("labels: [4, 3]"), HasSubstr("expected an integer in 4.."));
  EXPECT_THAT(rule("labels: [4, 5, 6]"), StartsWith("s.yaml:3:22: expected [FIRST, LAST]"));
  EXPECT_THAT(rule("modulus: 0"), HasSubstr("expected an integer in 1.."));
  EXPECT_THAT(rule("modulus: 3, remainder: 3"),
              HasSubstr("expected a remainder below the modulus 3, found 3"));
  EXPECT_THAT(rule("opacity: 1.5"), StartsWith("s.yaml:3:23: expected a number in 0..1"));
}

TEST_F(SceneFiles, FoundByNameOrPath) {
  load(kRest + kKeys);
  const std::string path = folder_ / "s.yaml";
  EXPECT_EQ(experiments::find_scene(path), path);
  for (const std::string name : {"cells", "fiber", "neurites", "atlas", "inside", "dense"}) {
    const Scene scene = experiments::load_scene(experiments::find_scene(name));
    EXPECT_EQ(scene.name, name);
    EXPECT_GE(scene.path.keys().size(), 4u);
    EXPECT_FALSE(scene.title.empty());
  }
  try {
    experiments::find_scene("dens");
    FAIL();
  } catch (const volumes::InputError& e) {
    EXPECT_THAT(e.what(),
                AllOf(HasSubstr("atlas, cells, ct, dense"), HasSubstr("did you mean 'dense'")));
  }
}

}  // namespace
}  // namespace cvr::gpu
