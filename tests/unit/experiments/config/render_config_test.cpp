// The render stage in configurations: products, values that do not matter, keys of rows, and every
// mistake at its place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "experiments/config/scene_file.hpp"
#include "experiments/run/load_config.hpp"
#include "gpu/caches/cache.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

constexpr const char* kLabelsAndScalars =
    "blob: {title: B, kind: labels, type: u32, extent: [10, 20, 30], generator: cells, seed: 1}\n"
    "cloud: {title: C, kind: scalars, type: u8, extent: [10, 20, 30], file: cloud.h5}\n";
constexpr const char* kScene =
    "title: S\nkeys: [{eye: [0, 0, 2]}]\nframes: 5\nsize: [80, 60]\nmaterials: [{labels: "
    "all}]\nshading: "
    "shadow\nlod_bias: 0.5\n";

class RenderConfig : public testing::Test {
 protected:
  RenderConfig() {
    folder_.write("datasets/a.yaml", kLabelsAndScalars);
    scene_ = folder_.write("still.yaml", kScene);
  }
  /// A configuration with one block of the render stage; `keys` are lines of it.
  Config load(const std::string& keys, const std::string& after = "",
              const std::string& codecs = "[raw]", const std::string& dataset = "blob") {
    const std::string text = "matrix:\n  - datasets: [" + dataset + "]\n    codecs: " + codecs +
                             "\n    stages: [render]\n" + keys + after;
    return load_config(folder_.write("c.yaml", text), Catalogue::from_folder(folder_ / "datasets"),
                       {});
  }
  std::string scene_line() const { return "    scenes: [" + scene_ + "]\n"; }
  std::string error(const std::string& keys, const std::string& after = "") {
    try {
      load(keys, after);
    } catch (const volumes::InputError& e) {
      const std::string what = e.what();
      return what.substr(what.find("c.yaml"));
    }
    return "no error";
  }
  ScratchFolder folder_;
  std::string scene_;
};

TEST_F(RenderConfig, TheSceneGivesWhatTheBlockLeavesOut) {
  const Config config = load(scene_line() + "    access_modes: [voxel]\n");
  ASSERT_EQ(config.cells.size(), 1u) << "no memcpy: a picture has no speed of light";
  const RenderChoice& choice = config.cells[0].render.value();
  EXPECT_EQ(choice.shading, gpu::Shading::kShadow);
  EXPECT_EQ(choice.width, 80u);
  EXPECT_EQ(choice.height, 60u);
  EXPECT_EQ(choice.frames, 5u);
  EXPECT_EQ(choice.lod_bias, 0.5);
  EXPECT_EQ(choice.cache_mib, 256u);
  EXPECT_EQ(choice.brick, 32u);
  const gpu::Scene scene = scene_of(choice);
  EXPECT_EQ(scene.width, 80u);
  EXPECT_EQ(scene.accumulate, 1u);
}

TEST_F(RenderConfig, ProductsLeaveOutWhatDoesNotMatter) {
  const Config config =
      load(scene_line() +
           "    access_modes: [none, voxel]\n    cache_mib: [1, 2]\n    shadings: "
           "[local, ao]\n    ao_samples: [1, 4]\n"
           "    lod_bias: [0, 1]\n    size: [8, 6]\n    frames: 3\n");
  // A mode without a cache has one size, a shading without random rays one number of samples: (1 +
  // 2) x (1 + 2) x 2.
  EXPECT_EQ(config.cells.size(), 18u);
  std::set<std::string> keys;
  for (const Cell& cell : config.cells) {
    keys.insert(cell.row_key());
    EXPECT_EQ(cell.render->width, 8u);
    EXPECT_EQ(cell.render->frames, 3u);
  }
  EXPECT_EQ(keys.size(), 18u);
}

TEST_F(RenderConfig, HeldFramesAreThoseOfOneKey) {
  const std::string keys = scene_line() + "    access_modes: [none]\n";
  EXPECT_EQ(load(keys).cells[0].render->warm_frames, 0u);
  EXPECT_EQ(load(keys + "    warm_frames: 1000\n").cells[0].render->warm_frames, 1000u);
  EXPECT_THAT(error(keys + "    warm_frames: 1001\n"),
              HasSubstr("c.yaml:7:18: expected an integer in 0..1000"));
  const std::string three =
      "title: S\nmaterials: [{}]\nkeys: [{eye: [0, 0, 2]}, {eye: [0, 1, 2]}, {eye: [0, 2, 2]}]\n";
  EXPECT_EQ(load_scene(folder_.write("first.yaml", three)).held, 0u);
  const gpu::Scene last = load_scene(folder_.write("last.yaml", three + "held: 2\n"));
  EXPECT_EQ(last.path.at(last.path.part_of(last.held)), last.path.keys()[2]);
  EXPECT_EQ(last.path.at(last.path.part_of(1)), last.path.keys()[1]);
  EXPECT_EQ(load_scene(scene_).path.part_of(0), 0);
  try {
    load_scene(folder_.write("beyond.yaml", three + "held: 3\n"));
    ADD_FAILURE();
  } catch (const volumes::InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("beyond.yaml:4:7: expected an integer in 0..2"));
  }
}

TEST_F(RenderConfig, AllMeansTheAccessModesThatServeTheVolume) {
  const auto modes = [&](const char* name) {
    std::set<std::string> ids;
    for (const Cell& cell : load(scene_line() + "    access_modes: all\n", "", "[raw]", name).cells)
      ids.insert(cell.render->access);
    return ids;
  };
  std::set<std::string> labels, scalars;
  for (const gpu::CacheTraits& cache : gpu::all_caches()) {
    if (!cache.exact) continue;
    if (cache.labels) labels.emplace(cache.id);
    if (cache.scalars) scalars.emplace(cache.id);
  }
  EXPECT_EQ(modes("blob"), labels);
  EXPECT_EQ(modes("cloud"), scalars);
  EXPECT_EQ(scalars, (std::set<std::string>{"none", "slices"}));
}

TEST_F(RenderConfig, ProgressiveStepsMultiply) {
  const Config config =
      load(scene_line() + "    access_modes: [slices]\n    steps: [0, 3]\n", "", "[raw]", "cloud");
  ASSERT_EQ(config.cells.size(), 2u);
  EXPECT_EQ(config.cells[0].render->step, 0u);
  EXPECT_EQ(config.cells[1].render->label("step"), "3");
  EXPECT_NE(config.cells[0].row_key(), config.cells[1].row_key());
  EXPECT_EQ(load(scene_line() + "    access_modes: [slices]\n", "", "[raw]", "cloud")
                .cells[0]
                .render->step,
            std::nullopt);
}

TEST_F(RenderConfig, ScenesOfScalarsHaveATransferFunction) {
  const std::string begin = "title: S\nkeys: [{eye: [0, 0, 2]}]\n";
  const gpu::Scene scene = load_scene(folder_.write(
      "t.yaml", begin + "transfer: [{value: 0, colour: [1, 2, 3], density: 0}, {value: 1, colour: "
                        "[4, 5, 6], density: 2}]\nslice_samples: 3\n"));
  ASSERT_EQ(scene.transfer.size(), 2u);
  EXPECT_EQ(scene.transfer[1].colour, (std::array<std::uint8_t, 3>{4, 5, 6}));
  EXPECT_EQ(scene.transfer[1].density, 2);
  EXPECT_EQ(scene.slice_samples, 3u);
  const auto error_of = [&](const std::string& rest) -> std::string {
    try {
      load_scene(folder_.write("e.yaml", begin + rest));
    } catch (const volumes::InputError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_THAT(error_of(""), HasSubstr("materials (of labels) or transfer (of scalars)"));
  EXPECT_THAT(
      error_of("transfer: [{value: 0.5, colour: [1, 2, 3], density: 0}, {value: 0.5, colour: [4, "
               "5, 6], density: 2}]\n"),
      HasSubstr("e.yaml:3:57: expected a value above that of the point before, 0.5, found 0.5"));
  EXPECT_THAT(error_of("transfer: [{value: 2, colour: [1, 2, 3], density: 0}]\n"),
              HasSubstr("e.yaml:3:20: expected a number in 0..1"));
}

TEST_F(RenderConfig, ACodecsOwnBrickIsThatOfTheCell) {
  const Config config = load(scene_line() + "    access_modes: [none]\n    brick: 16\n", "",
                             "[raw, {id: csgvr-sb, parameters: {brick: [32, 64]}}]");
  ASSERT_EQ(config.cells.size(), 3u);
  EXPECT_EQ(config.cells[0].render->brick, 16u);
  EXPECT_EQ(config.cells[1].render->brick, 32u);
  EXPECT_EQ(config.cells[2].render->brick, 64u);
}

TEST_F(RenderConfig, EveryChoiceMakesAnotherCellAndTheDeviceAnotherMeasurement) {
  const Cell cell = load(scene_line() + "    access_modes: [voxel]\n").cells[0];
  using Change = std::function<void(RenderChoice&)>;
  const std::vector<Change> changes{
      [](RenderChoice& c) { c.scene = "other"; },
      [](RenderChoice& c) { c.access = "none"; },
      [](RenderChoice& c) { c.cache_mib = 1; },
      [](RenderChoice& c) { c.shading = gpu::Shading::kAo; },
      [](RenderChoice& c) { c.width = 81; },
      [](RenderChoice& c) { c.height = 61; },
      [](RenderChoice& c) { c.frames = 6; },
      [](RenderChoice& c) { c.lod_bias = 1; },
      [](RenderChoice& c) { c.ao_samples = 2; },
      [](RenderChoice& c) { c.brick = 16; },
      [](RenderChoice& c) { c.jump_frames = 2; },
      [](RenderChoice& c) { c.image_error = true; },
      [](RenderChoice& c) { c.path_parts = 2; },
      [](RenderChoice& c) { c.ao_roulette = true; },
      [](RenderChoice& c) { c.count_path = false; },
      [](RenderChoice& c) { c.warm_frames = 2; },
      [](RenderChoice& c) { c.keep_images = true; },
      [](RenderChoice& c) { c.step = 1; },
  };
  std::set<std::string> keys{cell.row_key()}, ids{cell_id(cell, "0")};
  for (const auto& change : changes) {
    Cell other = cell;
    change(*other.render);
    keys.insert(other.row_key());
    ids.insert(cell_id(other, "0"));
    EXPECT_EQ(render_choice_from_row(to_row(*other.render)), *other.render);
  }
  EXPECT_EQ(keys.size(), changes.size() + 1);
  EXPECT_EQ(ids.size(), changes.size() + 1);
  for (const auto& change : std::vector<std::function<void(RenderChoice&)>>{
           [](RenderChoice& c) { c.device = "gpu"; },
           [](RenderChoice& c) { c.scene_hash = "0123456789abcdef"; }}) {
    Cell other = cell;
    change(*other.render);
    EXPECT_EQ(other.row_key(), cell.row_key());
    EXPECT_TRUE(ids.insert(cell_id(other, "0")).second);
  }
}

TEST_F(RenderConfig, ADeviceOnTheCommandLineWins) {
  Config config = load(scene_line() + "    access_modes: [none]\n", "device: llvmpipe\n");
  EXPECT_EQ(config.cells[0].render->device, "llvmpipe");
  choose_device(config, "1");
  EXPECT_EQ(config.cells[0].render->device, "1");
  EXPECT_EQ(config.device, "1");
}

TEST_F(RenderConfig, MistakesHaveTheirPlace) {
  EXPECT_THAT(error("    access_modes: [none]\n"),
              AllOf(HasSubstr("c.yaml:2:5: "), HasSubstr("scenes")));
  EXPECT_THAT(error(scene_line()), AllOf(HasSubstr("c.yaml:2:5: "), HasSubstr("access_modes")));
  EXPECT_THAT(error("    scenes: [inside, celsl]\n    access_modes: [none]\n"),
              AllOf(HasSubstr("c.yaml:5:22: "), HasSubstr("did you mean 'cells'?")));
  EXPECT_THAT(error(scene_line() + "    access_modes: [voxl]\n"),
              AllOf(HasSubstr("c.yaml:6:20: expected an access mode (none, voxel"),
                    HasSubstr("did you mean 'voxel'?")));
  EXPECT_THAT(error(scene_line() + "    access_modes: all\n    shadings: [locl]\n"),
              AllOf(HasSubstr("c.yaml:7:16: expected one of local, shadow, ao"),
                    HasSubstr("did you mean 'local'?")));
  EXPECT_THAT(error(scene_line() + "    access_modes: all\n    cache_mib: 0\n"),
              HasSubstr("c.yaml:7:16: expected an integer in 1.."));
  EXPECT_THAT(error(scene_line() + "    access_modes: all\n    size: [3]\n"),
              HasSubstr("c.yaml:7:11: expected two sides"));
  EXPECT_THAT(error(scene_line() + "    access_modes: all\n    brick: 24\n"),
              HasSubstr("c.yaml:7:12: expected a power of two"));
  EXPECT_THAT(error(scene_line() + "    access_modes: all\n    ao_smples: 2\n"),
              HasSubstr("did you mean 'ao_samples'?"));
  EXPECT_THAT(
      error(scene_line() + "    cache_mib: 4\n    access_modes: all\n",
            "  - {datasets: [blob], codecs: [raw], stages: [encode], frames: 3}\n"),
      AllOf(HasSubstr("c.yaml:8:5: "), HasSubstr("the stage render beside the key frames")));
}

TEST_F(RenderConfig, TablesSpreadAMetricOrHaveColumns) {
  const std::string good = scene_line() + "    access_modes: [none]\n";
  const auto table = [](const std::string& rest) {
    return "tables:\n  - {name: t, title: T, rows: [codec], " + rest + "}\n";
  };
  const Config config = load(good, table("pivot: {columns: [shading, dataset], metric: frame_ms}"));
  EXPECT_EQ(config.tables[0].pivot->metric, "frame_ms");
  EXPECT_TRUE(config.tables[0].renders());
  EXPECT_FALSE(load(good, table("columns: [rate]")).tables[0].renders());
  EXPECT_TRUE(load(good, table("columns: [rate], where: {scene: a}")).tables[0].renders());
  EXPECT_THAT(error(good, table("columns: [rate], pivot: {columns: [shading], metric: frame_ms}")),
              EndsWith("found several"));
  EXPECT_THAT(error(good, "tables:\n  - {name: t, title: T, rows: [codec]}\n"),
              EndsWith("found none"));
  EXPECT_THAT(error(good, table("pivot: {columns: [shadin], metric: frame_ms}")),
              HasSubstr("did you mean 'shading'?"));
  EXPECT_THAT(error(good, table("pivot: {columns: [shading], metric: frame_s}")),
              HasSubstr("did you mean 'frame_ms'?"));
}

TEST_F(RenderConfig, ConditionsKnowTheValues) {
  const Cell cell = load(scene_line() + "    access_modes: [voxel]\n").cells[0];
  EXPECT_TRUE(
      (Filter{{{"access_mode", "vox*"}, {"shading", "shadow"}, {"cache_mib", "256"}}}.keeps(cell)));
  EXPECT_FALSE((Filter{{{"access_mode", "none"}}}.keeps(cell)));
  Cell other = cell;
  other.render.reset();
  EXPECT_FALSE((Filter{{{"access_mode", "vox*"}}}.keeps(other)));
}

}  // namespace
}  // namespace cvr::experiments
