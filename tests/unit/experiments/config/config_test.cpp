// Configurations: every mistake is an error with its line and column; products expand in a fixed
// order.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "experiments/run/load_config.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "tests/unit/experiments/stage.hpp"
#include "volumes/error.hpp"
#include "volumes/io/io.hpp"

namespace cvr::experiments {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;

constexpr const char* kDatasets = R"(blob:
  title: "A blob"
  kind: labels
  type: u32
  extent: [10, 20, 30]
  generator: cells
  seed: 1
  stand_in_for: blob
scan:
  title: "A scan"
  kind: scalars
  type: u8
  extent: [4, 5, 6]
  file: "${CVRBENCH_DATA}/scan.h5"
)";

class ConfigTest : public testing::Test {
 protected:
  Config load(const std::string& text, const std::vector<std::string>& settings = {}) {
    folder_.write("datasets/a.yaml", kDatasets);
    const std::string path = folder_.write("c.yaml", text);
    return load_config(path, Catalogue::from_folder(folder_ / "datasets"), settings);
  }
  /// The error without the folder's name.
  std::string error(const std::string& text, const std::vector<std::string>& settings = {}) {
    try {
      load(text, settings);
    } catch (const volumes::InputError& e) {
      const std::string what = e.what();
      const std::size_t at = what.find("c.yaml");
      return at == std::string::npos ? what : what.substr(at);
    }
    return "no error";
  }
  void write_scene() {
    folder_.write("s.yaml",
                  "title: S\nkeys: [{eye: [0, 0, 2]}]\nframes: 5\nsize: [80, 60]\nmaterials: "
                  "[{labels: all}]\n");
  }
  ScratchFolder folder_;
};

constexpr const char* kGood = R"(title: T
matrix:
  - datasets: [blob]
    codecs: [raw]
    stages: [encode]
)";

TEST_F(ConfigTest, DefaultsAreStated) {
  const Config config = load(kGood);
  EXPECT_EQ(config.rounds, 9u);
  EXPECT_EQ(config.max_rounds, 27u);
  ASSERT_EQ(config.cells.size(), 2u);
  EXPECT_EQ(config.cells[0].codec, kMemcpy);
  EXPECT_EQ(config.cells[1].describe(), "blob raw encode, 1 thread");
}

TEST_F(ConfigTest, ProductsExpandInOrder) {
  const Config config = load(R"(matrix:
  - datasets: [{name: blob, scale: 0.5}]
    codecs: [{id: csgv-nibble, parameters: {brick: [16, 32], delta: [0, 1]}}]
    stages: [encode, decode]
    threads: [1, all]
)");
  std::vector<std::string> encode_one_thread;
  for (const Cell& cell : config.cells) {
    if (cell.stage->id == "encode" && cell.threads.text == "1")
      encode_one_thread.push_back(cell.parameters.canonical());
  }
  EXPECT_THAT(encode_one_thread, ElementsAre("", "brick=16;delta=0", "brick=16;delta=1",
                                             "brick=32;delta=0", "brick=32;delta=1"));
  EXPECT_EQ(config.cells.size(), 5u * 2 * 2);
  EXPECT_EQ(config.cells.back().threads.count, std::max(1u, std::thread::hardware_concurrency()));
  EXPECT_EQ(config.cells[0].dataset->generated_extent(), (volumes::Extent{5, 10, 15}));
}

TEST_F(ConfigTest, BlocksThatOverlapGiveEachCellOnce) {
  const Config config = load(R"(matrix:
  - {datasets: [blob], codecs: [raw], stages: [encode]}
  - {datasets: [blob], codecs: [raw, csgv-nibble], stages: [encode]}
)");
  EXPECT_EQ(config.cells.size(), 3u);
}

TEST_F(ConfigTest, UnknownKeyNamesPlaceAndNearestKey) {
  EXPECT_THAT(error(std::string(kGood) + "ruonds: 3\n"),
              HasSubstr("c.yaml:6:1: expected one of the keys title"));
  EXPECT_THAT(error(std::string(kGood) + "ruonds: 3\n"),
              EndsWith("found 'ruonds' (did you mean 'rounds'?)"));
}

TEST_F(ConfigTest, RepeatedKey) {
  EXPECT_EQ(error(std::string(kGood) + "title: U\n"),
            "c.yaml:6:1: expected each key once, found 'title' again");
}

TEST_F(ConfigTest, WrongType) {
  EXPECT_EQ(error(std::string(kGood) + "rounds: many\n"),
            "c.yaml:6:9: expected an integer in 1..100000, found 'many'");
  EXPECT_EQ(error(std::string(kGood) + "rounds: -1\n"),
            "c.yaml:6:9: expected an integer in 1..100000, found '-1'");
  EXPECT_EQ(error(std::string(kGood) + "timeout_s: [1]\n"),
            "c.yaml:6:12: expected a number in 0.01..10000000, found a list");
}

TEST_F(ConfigTest, EmptyOrMissingMatrix) {
  EXPECT_EQ(error("matrix: []\n"), "c.yaml:1:9: expected a list of blocks, found an empty list");
  EXPECT_EQ(error("title: T\n"), "c.yaml:1:1: expected the key 'matrix', found none");
  EXPECT_EQ(error("matrix:\n  - {datasets: [], codecs: [raw], stages: [encode]}\n"),
            "c.yaml:2:16: expected a list of data sets, found an empty list");
}

TEST_F(ConfigTest, UnknownCodecDatasetStageMetric) {
  EXPECT_THAT(error("matrix:\n  - {datasets: [blob], codecs: [rwa], stages: [encode]}\n"),
              testing::AllOf(HasSubstr("c.yaml:2:33: expected a codec of this build (raw"),
                             EndsWith("found 'rwa'")));
  EXPECT_THAT(error("matrix:\n  - {datasets: [blub], codecs: [raw], stages: [encode]}\n"),
              testing::AllOf(HasSubstr("c.yaml:2:17: "), HasSubstr("did you mean 'blob'?"),
                             EndsWith("found 'blub'")));
  EXPECT_EQ(error("matrix:\n  - {datasets: [blob], codecs: [raw], stages: [encoding]}\n"),
            "c.yaml:2:48: expected encode, decode, random-access, label-statistics or render, "
            "found 'encoding'");
  EXPECT_THAT(error(std::string(kGood) +
                    "tables:\n  - {name: a, title: b, rows: [dataset], columns: [ratte]}\n"),
              testing::AllOf(HasSubstr("c.yaml:7:52: "), HasSubstr("did you mean 'rat")));
}

TEST_F(ConfigTest, LabelsOfTableLinesAreKnownNames) {
  EXPECT_THAT(error(std::string(kGood) +
                    "tables:\n  - {name: a, title: b, rows: [brik], columns: [rate]}\n"),
              testing::AllOf(HasSubstr("c.yaml:7:32: expected one of dataset, extent"),
                             HasSubstr("did you mean 'brick'?")));
}

TEST_F(ConfigTest, ColumnsOfAPublicationNeedOne) {
  EXPECT_EQ(
      error(std::string(kGood) +
            "tables:\n  - {name: a, title: b, rows: [dataset], columns: [rate, published]}\n"),
      "c.yaml:7:5: expected the key published, for the column published is of a publication, "
      "found none");
}

TEST_F(ConfigTest, CodecParametersAreChecked) {
  EXPECT_EQ(error("matrix:\n  - datasets: [blob]\n    codecs: [{id: csgv-nibble, parameters: "
                  "{brick: 17}}]\n "
                  "   stages: [encode]\n"),
            "c.yaml:3:45: csgv-nibble: parameter 'brick': expected 16, 32, 64, found '17'");
  EXPECT_THAT(
      error("matrix:\n  - datasets: [blob]\n    codecs: [{id: csgv-nibble, parameters: {brik: "
            "16}}]\n    stages: [encode]\n"),
      HasSubstr("c.yaml:3:45: csgv-nibble: unknown parameter 'brik'"));
}

TEST_F(ConfigTest, BrokenYamlAndMissingFile) {
  EXPECT_THAT(error("matrix: [\n"), HasSubstr("c.yaml:2:1: expected YAML, found: "));
  EXPECT_THROW(load_config(folder_ / "none.yaml", Catalogue(), {}), volumes::InputError);
}

TEST_F(ConfigTest, SettingsWinAndAreChecked) {
  EXPECT_EQ(load(kGood, {"rounds=3", "scale=0.1"}).rounds, 3u);
  EXPECT_EQ(load(kGood, {"scale=0.1"}).cells[0].dataset->generated_extent(),
            (volumes::Extent{1, 2, 3}));
  EXPECT_THAT(error(kGood, {"rouns=3"}), EndsWith("found 'rouns' (did you mean 'rounds'?)"));
  EXPECT_EQ(error(kGood, {"rounds=x"}),
            "--set rounds:1:1: expected an integer in 1..100000, found 'x'");
}

TEST_F(ConfigTest, SettingsReachKeysOfBlocks) {
  const std::string two = R"(matrix:
  - {datasets: [blob], codecs: [raw, {id: csgvr, parameters: {brick: 32}}], stages: [encode]}
  - datasets: [blob]
    codecs: [{id: csgvr, frames: 9}]
    stages: [render]
    scenes: [s.yaml]
    access_modes: [none]
    per_dataset: {blob: {size: [8, 8]}}
)";
  write_scene();
  const auto image = [](const Config& config) { return *config.cells.back().render; };
  EXPECT_EQ(image(load(two)).frames, 9u);
  EXPECT_EQ(image(load(two)).width, 8u);
  EXPECT_EQ(image(load(two, {"frames=7"})).frames, 7u);
  EXPECT_EQ(image(load(two, {"size=20,10"})).width, 20u);
  EXPECT_EQ(image(load(two, {"matrix.1.size=20,10"})).width, 8u) << "the data set's own wins";
  EXPECT_EQ(image(load(two, {"matrix.1.per_dataset.blob.size=[20,10]"})).height, 10u);
  EXPECT_EQ(load(two, {"matrix.0.codecs.1.parameters.brick=64"}).cells[2].changes(), "brick=64");
  EXPECT_EQ(load(two, {"threads=1,2"}).cells.size(), load(two).cells.size() + 3);
  EXPECT_NE(load(two, {"frames=7"}).hash, load(two).hash);

  EXPECT_THAT(error(two, {"matrix.2.size=1,1"}),
              EndsWith("c.yaml:2:3: expected a place of the list, 0..1, or *, found '2'"));
  EXPECT_THAT(error(two, {"matrix.0.codes.1=raw"}),
              EndsWith("expected a key that is there, found 'codes'"));
  EXPECT_THAT(error(two, {"title.x=1"}), HasSubstr("expected a key that is there, found 'title'"));
  EXPECT_EQ(error(two, {"size=20"}),
            "c.yaml: expected a list of two sides [WIDTH, HEIGHT], found '20'");
  EXPECT_THAT(error(two, {"matrix.*.size=20,10"}),
              HasSubstr("expected the stage render beside the key size"));
  EXPECT_THAT(error(kGood, {"frames=3"}), HasSubstr("expected a block with the stage render"));
  EXPECT_THAT(error(two, {"sizes=3"}), HasSubstr("did you mean 'size'?"));
}

TEST_F(ConfigTest, CodecsAndDataSetsOfABlockHaveOptionsOfTheirOwn) {
  write_scene();
  const Config config = load(R"(matrix:
  - datasets: [blob, {generator: cells, extent: [9, 9, 9], name: other}]
    codecs:
      - {id: csgvr, parameters: {brick: 32}, access_modes: [none, voxel]}
      - {id: csgv-rans, parameters: {brick: 64}, access_modes: [brick], datasets: [other], cache_mib: 5}
    stages: [render]
    scenes: [s.yaml]
    frames: 2
    per_dataset: {other: {frames: 3, cache_mib: 4}}
)");
  std::vector<std::string> cells;
  for (const Cell& cell : config.cells)
    cells.push_back(fmt::format("{} {} {} {} {}", cell.dataset->name, cell.codec,
                                cell.render->access, cell.render->frames, cell.render->cache_mib));
  EXPECT_THAT(cells,
              ElementsAre("blob csgvr none 2 0", "blob csgvr voxel 2 256", "other csgvr none 3 0",
                          "other csgvr voxel 3 4", "other csgv-rans brick 3 5"));
  const std::string block =
      "matrix:\n  - datasets: [blob]\n    codecs: [{id: csgvr, datasets: [blub]}]\n    stages: "
      "[encode]\n";
  EXPECT_THAT(error(block), HasSubstr("found 'blub' (did you mean 'blob'?)"));
  EXPECT_THAT(error("matrix:\n  - datasets: [blob]\n    codecs: [raw]\n    stages: [render]\n    "
                    "per_dataset: {blob: {scenes: [s.yaml]}}\n"),
              HasSubstr("expected the key access_modes, which the stage render needs"));
}

TEST_F(ConfigTest, GeneratedVolumesAreDescribedInPlace) {
  const Config config = load(
      "matrix:\n  - {datasets: [{generator: worst-case, extent: [3, 4, 5]}], codecs: [raw], "
      "stages: "
      "[encode]}\n");
  EXPECT_EQ(config.cells[0].dataset->name, "worst-case-3x4x5");
  EXPECT_THAT(
      error(
          "matrix:\n  - {datasets: [{generator: worst, extent: [3, 4, 5]}], codecs: [raw], stages: "
          "[encode]}\n"),
      HasSubstr("c.yaml:2:29: expected one of "));
}

TEST(CellId, IsStableAndDependsOnEverything) {
  const auto make = [] {
    Cell cell;
    auto dataset = std::make_shared<Dataset>();
    dataset->name = "blob";
    cell.dataset = dataset;
    cell.codec = "raw";
    cell.codec_version = 1;
    cell.stage = stage("encode");
    return cell;
  };
  const Cell cell = make();
  // Golden: results of earlier runs are found by it.
  EXPECT_EQ(
      canonical_text(cell, "0123456789abcdef"),
      "measurement=2\ndataset=blob\ndata=0123456789abcdef\nbytes_per_voxel=0\ncodec=raw\nversion="
      "1\nparameters=\nstage=encode\n"
      "threads=1\n");
  EXPECT_EQ(cell_id(cell, "0123456789abcdef"), cell_id(make(), "0123456789abcdef"));
  EXPECT_EQ(cell_id(cell, "0123456789abcdef"), "ed506b969ed4fd41");
  EXPECT_NE(cell_id(cell, "0123456789abcdef"), cell_id(cell, "0123456789abcdee"));
  Cell other = make();
  other.codec_version = 2;
  EXPECT_NE(cell_id(other, "0123456789abcdef"), cell_id(cell, "0123456789abcdef"));
  other = make();
  other.stage = stage("decode");
  EXPECT_NE(cell_id(other, "0123456789abcdef"), cell_id(cell, "0123456789abcdef"));
}

TEST(Filter, GlobsOfOneKeyAreAlternativesAndKeysAllHold) {
  Cell cell;
  auto dataset = std::make_shared<Dataset>();
  dataset->name = "blob";
  cell.dataset = dataset;
  cell.codec = "csgvr-sb";
  EXPECT_TRUE((Filter{{{"codec", "csgv*"}}}.keeps(cell)));
  EXPECT_FALSE((Filter{{{"codec", "csgv"}}}.keeps(cell)));
  EXPECT_TRUE((Filter{{{"codec", "raw"}, {"codec", "csgv*"}}}.keeps(cell)));
  EXPECT_FALSE((Filter{{{"codec", "csgv*"}, {"dataset", "x"}}}.keeps(cell)));
  EXPECT_FALSE((Filter{{{"brick", "32"}}}.keeps(cell)));
}

TEST_F(ConfigTest, AbsentDataIsAReasonAndStandInsSaySo) {
  load(kGood);
  const Catalogue catalogue = Catalogue::from_folder(folder_ / "datasets");
  EXPECT_THAT(locate(*catalogue.find("scan"), {}).missing, HasSubstr("CVRBENCH_DATA"));
  EXPECT_THAT(locate(*catalogue.find("scan"), {folder_ / "", ""}).missing,
              HasSubstr("scan.h5 is absent"));
  Dataset blob = *catalogue.find("blob");
  blob.scale = 0.5;
  const Location location = locate(blob, {});
  EXPECT_TRUE(location.present);
  EXPECT_EQ(location.label, "stand-in for A blob, 5x10x15 of 10x20x30");
  Dataset other_seed = blob;
  other_seed.generator->seed = 2;
  EXPECT_NE(locate(other_seed, {}).identity, location.identity);
  EXPECT_EQ(locate(blob, {}).identity, location.identity);
}

TEST_F(ConfigTest, SeriesAreLocatedWholeOrByStep) {
  folder_.write(
      "datasets/b.yaml",
      "field:\n  title: F\n  kind: scalars\n  type: u8\n  extent: [6, 5, 4]\n  steps: 3\n  "
      "generator: moving\n"
      "kept:\n  title: K\n  kind: scalars\n  type: u8\n  extent: [6, 5, 4]\n  steps: 3\n  file: " +
          (folder_ / "k.h5") +
          "\nsecond:\n  title: S\n  kind: scalars\n  type: u8\n  extent: [6, 5, 4]\n  file: \"" +
          (folder_ / "k.h5[1]") +
          "\"\nshort:\n  title: S\n  kind: scalars\n  type: u8\n  extent: [6, 5, 4]\n  steps: 2\n  "
          "file: " +
          (folder_ / "k.h5") +
          "\nwrong:\n  title: W\n  kind: labels\n  type: u32\n  extent: [6, 5, 4]\n  steps: 2\n  "
          "generator: cells\n");
  const Catalogue catalogue = Catalogue::from_folder(folder_ / "datasets");
  const Location field = locate(*catalogue.find("field"), {});
  EXPECT_EQ(field.info.extent, (volumes::Extent{6, 5, 12}));
  EXPECT_EQ(field.info.time_steps, 3u);
  const auto source = open_location(field, 1);
  EXPECT_EQ(source->info().extent, field.info.extent);
  volumes::write_volume(folder_ / "k.h5", *source);
  EXPECT_EQ(locate(*catalogue.find("kept"), {}).info.time_steps, 3u);
  const Location second = locate(*catalogue.find("second"), {});
  EXPECT_EQ(second.info.time_steps, 1u);
  EXPECT_EQ(open_location(second, 1)->info().extent, (volumes::Extent{6, 5, 4}));
  EXPECT_THAT(
      locate(*catalogue.find("short"), {}).missing,
      HasSubstr("holds 6x5x4 in 3 time steps u8, its description says 6x5x4 in 2 time steps u8"));
  EXPECT_THROW(locate(*catalogue.find("wrong"), {}), volumes::InputError);
}

TEST_F(ConfigTest, ADamagedHashIsNoMatch) {
  folder_.write("datasets/b.yaml",
                "f:\n  title: F\n  kind: labels\n  type: u8\n  extent: [1, 1, 1]\n  file: " +
                    (folder_ / "c.yaml") + "\n  hash: 0123456789abcdef\n");
  folder_.write("c.yaml", "x");
  const Catalogue catalogue = Catalogue::from_folder(folder_ / "datasets");
  EXPECT_THAT(locate(*catalogue.find("f"), {}).missing,
              HasSubstr("its description says 0123456789abcdef"));
}

TEST_F(ConfigTest, AxesAndExternalFilesBelongToFilesAndToTheirIdentity) {
  const auto block = [](const std::string& dataset) {
    return "matrix:\n  - {datasets: [" + dataset + "], codecs: [raw], stages: [encode]}\n";
  };
  const Config plain = load(block("scan")),
               named = load(block("{name: scan, axes: zyx, allow_external: true}"));
  EXPECT_EQ(named.cells.front().dataset->axes, "zyx");
  EXPECT_TRUE(named.cells.front().dataset->allow_external);
  EXPECT_EQ(plain.cells.front().dataset->axes, "");
  EXPECT_FALSE(plain.cells.front().dataset->allow_external);
  EXPECT_NE(plain.cells.front().row_key(), named.cells.front().row_key());
  EXPECT_EQ(plain.cells.front().row_key(), "scan|4x5x6|memcpy||1|encode")
      << "keys of rows without axes stay as they were";
  EXPECT_EQ(error(block("{name: scan, axes: zy}")),
            "c.yaml:2:36: expected the letters x, y, z and where there are such axes t and c, each "
            "once, for "
            "instance zyx, found 'zy'");
  EXPECT_THAT(error(block("{name: scan, axes: zzyx}")), HasSubstr("found 'zzyx'"));
  EXPECT_THAT(error(block("{name: scan, allow_external: maybe}")),
              HasSubstr("expected true or false, found 'maybe'"));
  EXPECT_THAT(error(block("{name: blob, axes: zyx}")),
              HasSubstr("only for a file, found what is generated"));
}

TEST_F(ConfigTest, SizesThatNothingHoldsAreRefused) {
  EXPECT_THAT(error("matrix:\n  - {datasets: [{generator: cells, extent: [1048576, 1048576, "
                    "1048576]}], codecs: [raw], stages: [encode]}\n"),
              HasSubstr("voxels in all"));
  folder_.write("datasets/a.yaml",
                "huge:\n  title: T\n  kind: labels\n  type: u8\n  extent: [1099511627776, "
                "1099511627776, 1]\n  file: x.h5\n");
  EXPECT_THROW(Catalogue::from_folder(folder_ / "datasets"), volumes::InputError);
}

TEST_F(ConfigTest, NamesAreOneLineWithoutControlCharacters) {
  for (const char* title : {"\"a\\nb\"", "\"\\e[2J\"", "\"\\x9b\"", "|\n  a\n  b"})
    EXPECT_THAT(error(std::string("title: ") + title + "\nmatrix: []\n"),
                HasSubstr("of one line without control characters"))
        << title;
  const std::string table =
      std::string(kGood) +
      "tables:\n  - {name: NAME, title: b, rows: [dataset], columns: [rate]}\n";
  const auto named = [&](const std::string& name) {
    return std::string(table).replace(table.find("NAME"), 4, name);
  };
  for (const char* name : {"../a", "a/b", ".a", "\"\"", "\"a\\tb\""})
    EXPECT_NE(error(named(name)), "no error") << name;
  EXPECT_EQ(error(named("a b")), "no error");
  EXPECT_THAT(error(named("a") + "  - {name: a, title: b, rows: [dataset], columns: [rate]}\n"),
              HasSubstr("tables of different names, found 'a' twice"));
}

TEST_F(ConfigTest, StagesHaveNeighbours) {
  EXPECT_THAT(error("matrix:\n  - {datasets: [blob], codecs: [raw], stages: [encdoe]}\n"),
              HasSubstr("(did you mean 'encode'?)"));
}

}  // namespace
}  // namespace cvr::experiments
