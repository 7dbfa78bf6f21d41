// render, list access-modes, list devices and the render stage of run, on whatever Vulkan device
// there is; lavapipe will do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "gpu/caches/cache.hpp"
#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

/// Sets a variable of the environment, which the programs run here inherit, for the length of a
/// block.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    setenv(name, value.c_str(), 1);
  }
  ~Variable() { unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
};

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kRenderConfig = R"(title: T
rounds: 2
max_rounds: 2
timeout_s: 120
matrix:
  - datasets: [{generator: cells, extent: [48, 48, 48], name: blob}]
    codecs: [raw, zstd, csgvr-sb]
    stages: [render]
    scenes: [cells]
    access_modes: [none, voxel, brick]
    shadings: [local, ao]
    ao_samples: 2
    cache_mib: 4
    size: [96, 54]
    frames: 3
    jump_frames: 2
    warm_frames: 3
    image_error: 1
tables:
  - {name: t, title: Frames, rows: [codec, access_mode], pivot: {columns: [shading], metric: frame_ms}}
  - {name: e, title: Exactness, rows: [codec, access_mode, shading], columns: [label_mismatches, near_ties, converged_after, gpu_mib]}
)";

class Render : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(program_.run("generate cells --size 48,48,48 --seed 7 -o v.h5").exit_code, 0);
    program_.write("c.yaml", kRenderConfig);
  }
  std::vector<json> rows() const {
    std::istringstream in(program_.read("o/rows.jsonl"));
    std::vector<json> rows;
    for (std::string line; std::getline(in, line);) rows.push_back(json::parse(line));
    return rows;
  }
  Program program_;
};

TEST_F(Render, APictureFromAVolumeIsThatOfItsEncodedFile) {
  ASSERT_EQ(program_.run("encode v.h5 -o v.cvr --codec csgvr-sb").exit_code, 0);
  const std::string common =
      " --scene cells --size 96x54 --part 0.3 --shading shadow --cache-mib 4 ";
  const Outcome plain = program_.run("render v.h5" + common + "-o a.png --ids a.u64");
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  EXPECT_THAT(plain.out, HasSubstr("raw 48x48x48, access none, shadow 96x54"));
  const std::string labels = program_.read("a.u64");
  ASSERT_EQ(labels.size(), 96u * 54 * 8);
  std::set<std::uint64_t> seen;
  for (std::size_t at = 0; at < labels.size(); at += 8) {
    std::uint64_t label = 0;
    std::memcpy(&label, labels.data() + at, 8);
    seen.insert(label);
  }
  EXPECT_GT(seen.size(), 5u) << "the picture shows next to nothing";
  EXPECT_TRUE(program_.read("a.png").starts_with("\x89PNG"));
  const Outcome cached =
      program_.run("render v.cvr" + common + "--cache brick -o b.png --ids b.u64");
  ASSERT_EQ(cached.exit_code, 0) << cached.err;
  const Outcome encoded = program_.run(
      "render v.h5" + common + "--codec csgvr-sb -p brick=32 --cache voxel -o c.png --ids c.u64");
  ASSERT_EQ(encoded.exit_code, 0) << encoded.err;
  for (const std::string name : {"b", "c"}) {
    EXPECT_TRUE(program_.read(name + ".png") == program_.read("a.png")) << name << ".png differs";
    EXPECT_TRUE(program_.read(name + ".u64") == labels) << name << ".u64 differs";
  }
}

TEST_F(Render, ADeviceWithoutRoomForAllVoxelsIsHeldToTheReference) {
  program_.write("small.yaml", R"(rounds: 1
max_rounds: 1
matrix:
  - datasets: [{generator: cells, extent: [96, 96, 96], name: blob}]
    codecs: [raw, csgvr-sb]
    stages: [render]
    scenes: [cells]
    access_modes: [voxel]
    cache_mib: 1
    size: [96, 54]
    frames: 2
    warm_frames: 1
    jump_frames: 2
)");
  program_.run_with_fault("device-mib=2 *", "run small.yaml --out o");
  std::map<std::string, json> by_codec;
  for (const json& row : rows()) by_codec[row["codec"]["id"]] = row;
  EXPECT_EQ(by_codec["raw"]["status"], "unsupported");
  EXPECT_THAT(by_codec["raw"]["reason"].get<std::string>(),
              HasSubstr("exceed the device's largest allocation of 2097152"));
  const json& row = by_codec["csgvr-sb"];
  ASSERT_EQ(row["status"], "ok") << row["reason"];
  const json& verification = row["verification"];
  EXPECT_EQ(verification["pixels_compared"], 4 * 96 * 54);
  EXPECT_EQ(verification["label_mismatches"], 0);
  EXPECT_FALSE(verification.contains("same_as_raw"));
  EXPECT_EQ(row["jump"]["frames"].size(), 2u);
}

TEST_F(Render, SequencesAreNumberedAndReported) {
  const Outcome outcome = program_.run(
      "render v.h5 --scene inside --size 40x30 --shading ao --samples 2 --frames 3 -o s.png "
      "--json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["files"], json::array({"s_0000.png", "s_0001.png", "s_0002.png"}));
  EXPECT_EQ(report["first_frame_ms"].size(), 3u);
  EXPECT_EQ(report["samples"], 2);
  EXPECT_GT(report["gpu_bytes"].get<double>(), 48.0 * 48 * 48 * 4);
  EXPECT_FALSE(report["device"]["name"].get<std::string>().empty());
  for (const char* name : {"s_0000.png", "s_0001.png", "s_0002.png"})
    EXPECT_FALSE(program_.read(name).empty()) << name;
  EXPECT_TRUE(program_.read("s_0000.png") != program_.read("s_0002.png"))
      << "the camera stands still";
}

TEST_F(Render, MistakesAreOneClearLine) {
  ASSERT_EQ(program_.run("encode v.h5 -o z.cvr --codec zstd").exit_code, 0);
  const std::map<std::string, std::string> expected{
      {"render v.h5 --scene celsl -o a.png", "did you mean 'cells'?"},
      {"render v.h5 --scene cells --cache voxl -o a.png", "did you mean 'voxel'?"},
      {"render v.h5 --scene cells --codec rwa -o a.png", "--codec: expected one of"},
      {"render v.h5 --scene cells --size 96 -o a.png", "expected WIDTHxHEIGHT"},
      {"render none.h5 --scene cells -o a.png", "none.h5"},
      {"render z.cvr --scene cells -o a.png", "z.cvr: this codec has no decoder for the GPU"},
      {"render z.cvr --scene cells --codec raw -o a.png",
       "expected --codec and -p only with a volume"},
      {"render v.h5 --scene cells --codec csgv-rans --cache none -o a.png", "whole bricks"}};
  for (const auto& [arguments, text] : expected) {
    const Outcome outcome = program_.run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_THAT(outcome.err, HasSubstr(text)) << arguments;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << arguments << ": " << outcome.err;
  }
}

TEST_F(Render, NoUsableDeviceIsTheEnvironmentsFault) {
  const std::string name =
      json::parse(program_.run("list devices --json").out)[0]["name"].get<std::string>();
  for (const std::string command : {"render v.h5 --scene cells -o a.png --device nonsense",
                                    "run c.yaml --out o --device nonsense"}) {
    const Outcome outcome = program_.run(command);
    EXPECT_EQ(outcome.exit_code, 3) << command;
    EXPECT_THAT(outcome.err, HasSubstr("nonsense")) << command;
    EXPECT_THAT(outcome.err, HasSubstr(name)) << "the devices that there are belong in the message";
  }
  EXPECT_EQ(program_.read("o/rows.jsonl"), "") << "a run without a device makes no rows";
}

TEST_F(Render, WithoutADriverTheErrorSaysWhatToInstall) {
  program_.write("empty.json", "");
  program_.write(
      "nowhere.json",
      R"({"file_format_version": "1.0.0", "ICD": {"library_path": "none.so", "api_version": "1.3.0"}})");
  for (const std::string file : {"empty.json", "nowhere.json", "nonexistent.json"}) {
    const Variable old_name("VK_ICD_FILENAMES", program_ / file),
        new_name("VK_DRIVER_FILES", program_ / file);
    for (const std::string command : {"render v.h5 --scene cells -o a.png", "run c.yaml --out o"}) {
      const Outcome outcome = program_.run(command);
      EXPECT_EQ(outcome.exit_code, 3) << file << " " << command;
      EXPECT_THAT(outcome.err, HasSubstr("cvrbench: no Vulkan device that can draw; "))
          << file << " " << command;
      EXPECT_THAT(outcome.err, HasSubstr("mesa-vulkan-drivers holds lavapipe"))
          << file << " " << command;
      EXPECT_EQ(program_.read("o/rows.jsonl"), "") << "a run without a device makes no rows";
    }
    EXPECT_EQ(program_.run("list devices").exit_code, 3) << file;
  }
}

TEST_F(Render, EachRejectedDeviceSaysWhy) {
  program_.write(
      "driver.json",
      R"({"file_format_version": "1.0.0", "ICD": {"library_path": ")" CVRBENCH_UNUSABLE_DRIVER
      R"(", "api_version": "1.3.0"}})");
  const Variable old_name("VK_ICD_FILENAMES", program_ / "driver.json"),
      new_name("VK_DRIVER_FILES", program_ / "driver.json");
  const json list = json::parse(program_.run("list devices --json").out);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0]["rejected"], json::array({"Vulkan 1.1.5, expected 1.3"}));
  EXPECT_FALSE(list[1]["usable"].get<bool>());
  EXPECT_EQ(program_.run("list devices").exit_code, 3);
  for (const std::string command : {"render v.h5 --scene cells -o a.png", "run c.yaml --out o"}) {
    const Outcome outcome = program_.run(command);
    EXPECT_EQ(outcome.exit_code, 3) << command;
    EXPECT_THAT(outcome.err,
                HasSubstr("no Vulkan device that can draw; device 0 (Old, discrete): Vulkan 1.1.5, "
                          "expected 1.3; device 1 "
                          "(Bare, discrete): no arithmetic and ballots of subgroups in compute "
                          "shaders, lacks the feature shaderBufferInt64Atomics, "))
        << command;
    EXPECT_THAT(outcome.err, HasSubstr(", no compute queue with timestamps\n")) << command;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << command << ": " << outcome.err;
  }
  const Outcome chosen = program_.run("render v.h5 --scene cells -o a.png --device bare");
  EXPECT_EQ(chosen.exit_code, 3);
  EXPECT_THAT(chosen.err,
              HasSubstr("(Old, discrete): Vulkan 1.1.5, expected 1.3, is not 'bare'; "));
}

TEST_F(Render, ALostDeviceFailsItsCellsAndTheOthersGoOn) {
  program_.write("f.yaml", kRenderConfig);
  const Outcome outcome = program_.run_with_fault(
      "device-lost csgvr-sb",
      "run f.yaml --out o --only codec=raw --only codec=csgvr-sb --only access_mode=brick --only "
      "cache=none "
      "--only shading=local --set timeout_s=60");
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  const std::string name =
      json::parse(program_.run("list devices --json").out)[0]["name"].get<std::string>();
  const auto all = rows();
  ASSERT_EQ(all.size(), 4u);
  for (const json& row : all) {
    const std::string key = row["key"];
    if (row["codec"]["id"] == "raw") {
      EXPECT_EQ(row["status"], "ok") << key;
      EXPECT_EQ(row["time"]["rounds"], 2) << key;
      continue;
    }
    EXPECT_EQ(row["status"], "failed") << key;
    EXPECT_THAT(
        row["reason"].get<std::string>(),
        testing::AllOf(HasSubstr(name),
                       HasSubstr("running the passes clear: vkWaitForFences: device lost (-4)")))
        << key;
    EXPECT_FALSE(row.contains("frames") || row.contains("held"))
        << key << ": a cell that failed has no time";
  }
  // A wrong picture is a finding about the codec, whatever the device does beside it.
  EXPECT_EQ(program_
                .run_with_fault("mismatch csgvr-sb",
                                "run f.yaml --out g --only codec=csgvr-sb --only access_mode=none "
                                "--only shading=local")
                .exit_code,
            1);
}

TEST_F(Render, ListsAccessModesAndDevices) {
  const json caches = json::parse(program_.run("list access-modes --json").out);
  ASSERT_EQ(caches.size(), gpu::all_caches().size());
  EXPECT_EQ(caches[0]["id"], "none");
  EXPECT_EQ(caches[0]["sized"], false);
  EXPECT_THAT(program_.run("list access-modes").out, HasSubstr("brick-coop-shared"));
  const Outcome devices = program_.run("list devices --json");
  ASSERT_EQ(devices.exit_code, 0) << "these tests need a Vulkan device: " << devices.out
                                  << devices.err;
  const json list = json::parse(devices.out);
  EXPECT_TRUE(std::ranges::any_of(list, [](const json& d) { return d["usable"].get<bool>(); }));
  EXPECT_THAT(program_.run("list devices").out, HasSubstr(list[0]["name"].get<std::string>()));
}

TEST_F(Render, ARunChecksMeasuresAndTabulatesPictures) {
  const Outcome outcome = program_.run("run c.yaml --out o");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto all = rows();
  ASSERT_EQ(all.size(), 3u * 3 * 2);
  EXPECT_FALSE(std::filesystem::exists(program_ / "o/scratch"))
      << "reference pictures are scratch too";
  for (const json& row : all) {
    const std::string key = row["key"];
    if (row["codec"]["id"] == "zstd") {
      EXPECT_EQ(row["status"], "unsupported") << key;
      EXPECT_EQ(row["reason"], "no decoder for the GPU");
      continue;
    }
    ASSERT_EQ(row["status"], "ok") << key << row["reason"];
    EXPECT_EQ(row["verification"]["pixels_compared"], (3 + 1) * 96 * 54)
        << key << ": three views and a held frame";
    EXPECT_EQ(row["verification"]["label_mismatches"], 0) << key;
    EXPECT_EQ(row["verification"]["mismatches"], 0) << key;
    const std::size_t samples = row["render"]["ao_samples"];
    EXPECT_EQ(samples, row["render"]["shading"] == "ao" ? 2u : 1u);
    EXPECT_EQ(row["frames"]["count"], 3 * samples) << key;
    EXPECT_EQ(row["frames"]["ms"].size(), 2u);
    EXPECT_GT(row["frames"]["mean_ms"].get<double>(), 0);
    EXPECT_TRUE(row["frames"]["passes"].contains("render"));
    EXPECT_GT(row["memory"]["gpu_bytes"].get<double>(), 96.0 * 54 * 24);
    EXPECT_GE(row["counters"]["rays"].get<double>(), 3.0 * 96 * 54) << key;
    EXPECT_GT(row["needed"]["distinct_cells"].get<double>(), 100) << key;
    EXPECT_GE(row["needed"]["decoded_over_needed"].get<double>(), 1) << key;
    EXPECT_GE(row["exact_after_frames"].get<int>(), row["render"]["cache"] == "brick" ? 2 : 1)
        << key;
    EXPECT_EQ(row["frames"]["incomplete"]["first"].get<int>() > 0,
              row["render"]["cache"] == "brick")
        << key;
    const json& held = row["held"];
    EXPECT_EQ(held["count"], 3) << key << ": frames of the held view, whatever the samples";
    EXPECT_EQ(held["ms"].size(), 2u) << key;
    EXPECT_GT(held["median_ms"].get<double>(), 0) << key;
    EXPECT_EQ(held["incomplete"]["largest"], 0) << key;
    EXPECT_EQ(held["compared"], true) << key;
    EXPECT_TRUE(held["passes"].contains("render")) << key;
    EXPECT_GT(held["cells_read"].get<double>(), 1000) << key;
    if (row["render"]["cache"] == "none") {
      EXPECT_TRUE(held["cache_complete"].is_null()) << key;
      EXPECT_EQ(held["cells_decoded"], held["cells_read"]) << key;
    } else {
      EXPECT_LE(held["cells_decoded"].get<double>(), 0.01 * held["cells_read"].get<double>())
          << key << ": the cache is filled";
      EXPECT_EQ(held["cache_complete"], held["cells_decoded"] == 0) << key;
    }
    ASSERT_EQ(row["jump"]["frames"].size(), 2u);
    if (row["render"]["cache"] != "brick" && row["render"]["shading"] == "local") {
      EXPECT_EQ(row["jump"]["frames"][0]["label_mismatches"], 0)
          << key << ": random access has no latency";
    }
    EXPECT_EQ(row["picture_error"]["label_mismatches"], 0) << key;
    EXPECT_EQ(row["picture_error"]["psnr_db"].is_null() ||
                  row["picture_error"]["psnr_db"].get<double>() > 60,
              row["render"]["shading"] == "local")
        << key << ": two random rays are not 256";
    EXPECT_FALSE(row["render"].contains("scene_path"));
  }
  EXPECT_THAT(program_.read("o/tables/t.csv"), testing::StartsWith("codec,access_mode,local,ao\n"));
  EXPECT_THAT(program_.read("o/tables/e.md"), HasSubstr("Drawn on: "));
  const Outcome again = program_.run("plan c.yaml --out o");
  EXPECT_THAT(again.out, HasSubstr("0 to run, 12 done, 6 unsupported"));
}

TEST_F(Render, PicturesAreKeptBesideTheRows) {
  program_.write("k.yaml", R"(rounds: 1
max_rounds: 1
matrix:
  - datasets: [{generator: cells, extent: [16, 16, 16], name: "my blob"}]
    codecs: [raw]
    stages: [render]
    scenes: [cells]
    access_modes: [none]
    size: [48, 27]
    frames: 1
    keep_images: 1
  - datasets: [{generator: shells, extent: [16, 16, 16], name: walls}]
    codecs: [raw, {id: vq, parameters: {bits: 2}}]
    stages: [render]
    scenes: [ct]
    access_modes: [slices]
    size: [48, 27]
    frames: 1
    keep_images: 1
)");
  const Outcome outcome = program_.run("run k.yaml --out o");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::istringstream in(program_.read("o/rows.jsonl"));
  std::size_t count = 0;
  for (std::string line; std::getline(in, line); ++count) {
    const json row = json::parse(line), kept = row["pictures"];
    const std::string id = row["codec"]["id"], name = row["dataset"]["name"];
    EXPECT_EQ(kept["picture"], (name == "walls" ? "walls-" + id + "-ct-" : "my_blob-raw-cells-") +
                                   row["cell"].get<std::string>() + ".png");
    for (const char* key : {"picture", "difference"})
      EXPECT_THAT(program_.read("o/pictures/" + kept[key].get<std::string>()),
                  testing::StartsWith("\x89PNG"))
          << key;
    EXPECT_NE(program_.read("o/pictures/" + kept["picture"].get<std::string>()),
              program_.read("o/pictures/" + kept["difference"].get<std::string>()));
    if (id == "vq") {
      EXPECT_LT(kept["psnr_db"].get<double>(), 50) << "four code vectors";
    } else {
      EXPECT_TRUE(kept["psnr_db"].is_null() || kept["psnr_db"].get<double>() > 60);
    }
  }
  EXPECT_EQ(count, 3u);
}

TEST_F(Render, ACacheTooSmallForAHeldViewIsReported) {
  program_.write("s.yaml", R"(rounds: 2
max_rounds: 2
timeout_s: 120
matrix:
  - datasets: [{generator: cells, extent: [160, 160, 160], name: blob}]
    codecs: [{id: csgvr-sb, parameters: {brick: 32}}]
    stages: [render]
    scenes: [dense]
    access_modes: [voxel, brick]
    cache_mib: [1, 16]
    lod_bias: -8
    size: [64, 40]
    frames: 1
    warm_frames: 2
tables:
  - {name: t, title: T, rows: [access_mode, cache_mib], columns: [frame_warm_ms, warm_cache, warm_cells_decoded, warm_incomplete, status]}
)");
  const Outcome outcome = program_.run("run s.yaml --out o");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const json& row : rows()) {
    ASSERT_EQ(row["status"], "ok") << row["reason"];
    const bool small = row["render"]["cache"] == "brick" && row["render"]["cache_mib"] == 1;
    EXPECT_EQ(row["held"]["incomplete"]["largest"].get<double>() > 0, small) << row["key"];
    EXPECT_EQ(row["held"]["compared"], !small) << row["key"];
    // A voxel cache may lose one of two cells that keep pushing each other out.
    if (row["render"]["cache"] == "voxel") {
      EXPECT_LE(row["held"]["cells_decoded"], 5) << row["key"];
    } else {
      EXPECT_EQ(row["held"]["cache_complete"], !small) << row["key"];
    }
    EXPECT_EQ(row["verification"]["pixels_compared"], (small ? 3 : 4) * 64 * 40) << row["key"];
  }
  EXPECT_THAT(program_.read("o/tables/t.csv"),
              testing::ContainsRegex("brick,1,[0-9.e+]+; [0-9.e+]+,part,"));
  EXPECT_THAT(program_.read("o/tables/t.csv"),
              testing::ContainsRegex("brick,16,[0-9.e+]+; [0-9.e+]+,all,0,0,ok"));
}

TEST_F(Render, AFileThatDiffersFromTheVolumeFails) {
  program_.write("f.yaml", kRenderConfig);
  const Outcome outcome = program_.run_with_fault(
      "mismatch csgvr-sb",
      "run f.yaml --out o --only codec=csgvr-sb --only access_mode=none --only shading=local");
  EXPECT_EQ(outcome.exit_code, 1);
  const auto all = rows();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0]["status"], "failed");
  EXPECT_FALSE(all[0].contains("frames"));
}

}  // namespace
}  // namespace cvr::cli_tests
