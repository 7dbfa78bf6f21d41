// Frame times of rounds, the columns of pictures, and tables that spread a metric over columns.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codecs/registry.hpp"
#include "experiments/analysis/metrics.hpp"
#include "experiments/analysis/tables.hpp"
#include "experiments/config/published.hpp"
#include "experiments/stages/frame_times.hpp"
#include "gpu/caches/cache.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "tests/unit/experiments/results_of.hpp"
#include "tests/unit/experiments/stage.hpp"

namespace cvr::experiments {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(FrameTimes, LaterRoundsCountAndTheFirstStandsApart) {
  Measured measured;
  for (const double slow : {4.0, 1.0, 2.0}) {
    std::vector<Sample> samples{{"path", 0, 0, 2}};
    for (int frame = 0; frame < 2; ++frame) {
      samples.push_back({"frame", 1e-3 * slow * (frame + 1), 5e-3, frame == 0 ? 7u : 0u});
      samples.push_back({"pass/decode", 1e-3 * frame, 0, 0});
      samples.push_back({"pass/render", 1e-3 * slow, 0, 0});
    }
    measured.add(samples);
  }
  const Parts::Frames frames = describe_frames(measured).value();
  EXPECT_EQ(frames.count, 2u);
  EXPECT_EQ(frames.rounds, 3u);
  EXPECT_DOUBLE_EQ(frames.mean_ms.value(), (1 + 2 + 2 + 4) / 4.0);
  EXPECT_DOUBLE_EQ(frames.median_ms.value(), 2);
  EXPECT_DOUBLE_EQ(frames.first_round_mean_ms.value(), 6);
  EXPECT_DOUBLE_EQ(frames.first_frame_ms.value(), 2) << "median of 4, 1 and 2";
  EXPECT_EQ(frames.first.size(), 2u);
  EXPECT_DOUBLE_EQ(frames.passes->find("render")->mean_ms, 1.5);
  EXPECT_DOUBLE_EQ(frames.passes->find("decode")->median_ms, 0.5);
  EXPECT_DOUBLE_EQ(frames.host_median_ms.value(), 5);
  EXPECT_EQ(frames.incomplete->first, 7u);
  EXPECT_EQ(frames.incomplete->largest, 7.0);
  ASSERT_EQ(frames.ms.size(), 3u);
  EXPECT_DOUBLE_EQ(frames.ms[2][1], 4);
}

TEST(FrameTimes, HeldFramesHaveTheSameStatisticsAndStandApart) {
  Measured measured;
  for (const double slow : {9.0, 1.0, 3.0}) {
    std::vector<Sample> samples{{"path", 0, 0, 1}, {"frame", 1, 0, 0}, {"pass/render", 1, 0, 0}};
    for (int frame = 0; frame < 3; ++frame) {
      samples.push_back({"held", 1e-3 * slow * (frame + 1), 7e-3, frame == 2 ? 5u : 0u});
      samples.push_back({"held-pass/render", 1e-3 * slow, 0, 0});
    }
    measured.add(samples);
  }
  Parts::Held held;
  ASSERT_TRUE(add_held_frames(measured, held));
  EXPECT_EQ(held.count, 3u);
  EXPECT_EQ(held.rounds, 3u);
  EXPECT_DOUBLE_EQ(held.mean_ms.value(), (1 + 2 + 3 + 3 + 6 + 9) / 6.0);
  EXPECT_DOUBLE_EQ(held.median_ms.value(), 3);
  EXPECT_DOUBLE_EQ(held.passes->find("render")->mean_ms, 2);
  EXPECT_DOUBLE_EQ(held.host_median_ms.value(), 7);
  EXPECT_EQ(held.incomplete->largest, 5.0);
  const Parts::Frames frames = describe_frames(measured).value();
  EXPECT_EQ(frames.count, 1u);
  EXPECT_EQ(frames.passes->size(), 1u);
  EXPECT_DOUBLE_EQ(frames.passes->find("render")->mean_ms, 1000);
  Measured without;
  without.add({{"path", 0, 0, 1}, {"frame", 1, 0, 0}});
  EXPECT_FALSE(add_held_frames(without, held));
}

TEST(FrameTimes, ASingleRoundIsAllThereIs) {
  Measured measured;
  measured.add({{"path", 0, 0, 1}, {"frame", 3e-3, 0, 0}, {"pass/render", 3e-3, 0, 0}});
  const Parts::Frames frames = describe_frames(measured).value();
  EXPECT_DOUBLE_EQ(frames.mean_ms.value(), 3);
  EXPECT_DOUBLE_EQ(frames.first_round_mean_ms.value(), 3);
  EXPECT_DOUBLE_EQ(frames.passes->find("render")->mean_ms, 3);
}

std::string text_of(const char* metric, const Row& row) {
  const auto result = from_json<Result>(row);
  LineContext line;
  line.rows["render"] = &result;
  return find_metric(metric)->read(line).text;
}

TEST(RenderMetrics, ReadTheRow) {
  const Row row = Row::parse(R"({"status": "ok", "frames": {"mean_ms": 12.3456, "p99_ms": 0.01234},
    "verification": {"near_ties": 2, "psnr_db": null}, "memory": {"gpu_bytes": 3145728}, "start": {"upload_s": 0.5, "kernels_s": 0.25},
    "jump": {"frames": [{"psnr_db": 12.34, "label_mismatches": 9, "ms": 1}, {"psnr_db": null, "label_mismatches": 0, "ms": 2}]},
    "needed": {"decoded_over_needed": 1.5}, "counters": {"words_touched": 262144}})");
  EXPECT_EQ(text_of("frame_ms", row), "12.35");
  EXPECT_EQ(text_of("frame_p99_ms", row), "0.01234");
  EXPECT_EQ(text_of("near_ties", row), "2");
  EXPECT_EQ(text_of("psnr_db", row), "exact");
  EXPECT_EQ(text_of("gpu_mib", row), "3.0");
  EXPECT_EQ(text_of("start_s", row), "0.750");
  EXPECT_EQ(text_of("jump_psnr_db", row), "12.3 / exact");
  EXPECT_EQ(text_of("jump_label_errors", row), "9 / 0");
  EXPECT_EQ(text_of("needed_ratio", row), "1.50");
  EXPECT_EQ(text_of("bytes_touched", row), "1.00");
  EXPECT_EQ(text_of("frame_median_ms", row), "") << "no number";
  EXPECT_EQ(text_of("frame_ms", {{"status", "unsupported"}}), "unsupported");
}

TEST(RenderMetrics, HeldFramesStandBesideThePath) {
  Row row = Row::parse(
      R"({"status": "ok", "frames": {"mean_ms": 12.3456}, "held": {"median_ms": 1.5, "mean_ms": 2, "p95_ms": 4,
    "count": 5, "incomplete": {"largest": 3}, "cells_decoded": 20, "cache_complete": false}})");
  EXPECT_EQ(text_of("warm_ms", row), "1.5");
  EXPECT_EQ(text_of("warm_mean_ms", row), "2");
  EXPECT_EQ(text_of("warm_p95_ms", row), "4");
  EXPECT_EQ(text_of("warm_frames", row), "5");
  EXPECT_EQ(text_of("warm_incomplete", row), "3");
  EXPECT_EQ(text_of("warm_cells_decoded", row), "20");
  EXPECT_EQ(text_of("warm_cache", row), "part");
  EXPECT_EQ(text_of("frame_warm_ms", row), "12.35; 1.5");
  row["held"]["cache_complete"] = true;
  EXPECT_EQ(text_of("warm_cache", row), "all");
  row["held"]["cache_complete"] = nullptr;
  EXPECT_EQ(text_of("warm_cache", row), "") << "no cache";
  row.erase("held");
  EXPECT_EQ(text_of("frame_warm_ms", row), "12.35");
  EXPECT_EQ(text_of("warm_ms", row), "");
  EXPECT_EQ(text_of("frame_warm_ms", {{"status", "failed"}}), "failed");
}

class RenderTable : public testing::Test {
 protected:
  RenderTable() {
    for (const char* name : {"a", "b"}) {
      auto dataset = std::make_shared<Dataset>();
      dataset->name = name;
      for (const gpu::Shading shading : {gpu::Shading::kLocal, gpu::Shading::kAo}) {
        for (const char* cache : {"none", "voxel"}) {
          Cell cell{dataset, "raw", 1, {}, stage("render"), {"all", 2}, RenderChoice{}};
          cell.render->scene = "s";
          cell.render->access = cache;
          cell.render->shading = shading;
          config_.cells.push_back(cell);
        }
      }
      config_.cells.push_back({dataset, "raw", 1, {}, stage("encode"), {"1", 1}});
    }
    spec_.name = spec_.title = "t";
    spec_.rows = {"codec", "access_mode"};
    spec_.pivot = Pivot{{"shading", "dataset"}, "frame_ms"};
    const std::string published =
        folder_.write("p.yaml",
                      "citation: C\nhardware: old\ntables:\n  t4:\n    title: T4\n    hardware: "
                      "GPU\n    figures:\n"
                      "      - {dataset: a, codec: raw, cache: voxel, shading: ao, frame_ms: 9.7}\n"
                      "      - {dataset: a, codec: raw, rate: 1}\n");
    spec_.published = {published, "t4"};
  }
  std::vector<Row> rows() const {
    std::vector<Row> rows;
    for (const Cell& cell : config_.cells) {
      Row row{{"cell", cell.row_key()}, {"key", cell.row_key()}, {"status", "ok"}, {"reason", ""}};
      row["frames"]["mean_ms"] = static_cast<double>(rows.size());
      row["device"] = {{"name", "pipe"}, {"type", "software"}, {"driver", "D"}};
      rows.push_back(row);
    }
    return rows;
  }
  ScratchFolder folder_;
  Config config_;
  TableSpec spec_;
};

std::vector<std::string> headings_of(const Table& table) {
  std::vector<std::string> headings;
  for (const TableColumn& column : table.columns) headings.push_back(column.heading);
  return headings;
}

std::vector<std::string> texts_of(const LineOfCells& line) {
  std::vector<std::string> texts;
  for (const TableCell& cell : line.cells) texts.push_back(cell.text);
  return texts;
}

std::vector<std::string> notes_of(const Table& table) {
  std::vector<std::string> notes;
  for (const Note& note : table.notes) notes.push_back(note.plain());
  return notes;
}

TEST_F(RenderTable, OneColumnForEachCombinationMeasuredAndPublished) {
  const Table table = make_table(spec_, config_, results_of(rows()));
  EXPECT_THAT(headings_of(table),
              ElementsAre("codec", "access_mode", "local a", "local b", "ao a", "ao b"));
  ASSERT_EQ(table.lines.size(), 2u);
  EXPECT_THAT(texts_of(table.lines[0]), ElementsAre("raw", "none", "0", "5", "2", "7"));
  EXPECT_THAT(texts_of(table.lines[1]), ElementsAre("raw", "voxel", "1", "6", "3 (9.7)", "8"));
  EXPECT_THAT(notes_of(table), testing::Contains(HasSubstr("Times there: GPU.")));
  EXPECT_EQ(table.columns[2].name, "frame_ms");
  EXPECT_EQ(table.columns[2].unit, "ms");
  const TableCell& cell = table.lines[1].cells[4];
  EXPECT_EQ(cell.number, 3);
  EXPECT_EQ(cell.published->text, "9.7");
  EXPECT_EQ(cell.published->number, 9.7);
  EXPECT_EQ(table.published->hardware, "GPU");
}

TEST_F(RenderTable, PathHeldViewAndPublicationShareACell) {
  spec_.pivot->metric = "frame_warm_ms";
  auto with_held = rows();
  with_held[3]["held"]["median_ms"] = 0.25;
  const Table table = make_table(spec_, config_, results_of(with_held));
  EXPECT_THAT(texts_of(table.lines[1]),
              ElementsAre("raw", "voxel", "1", "6", "3; 0.25 (9.7)", "8"));
  EXPECT_EQ(table.lines[1].cells[4].number, 3) << "the first figure of several";
  EXPECT_THAT(notes_of(table),
              testing::Contains(HasSubstr("in parentheses what the publication states")));
}

TEST_F(RenderTable, TimesOfASoftwareDeviceCarryTheWarning) {
  const Table table = make_table(spec_, config_, results_of(rows()));
  EXPECT_THAT(notes_of(table), testing::Contains("Drawn on: pipe (software, D)."));
  EXPECT_THAT(notes_of(table),
              testing::Contains(HasSubstr("CPU times, not comparable with those of a GPU")));
  auto on_gpu = rows();
  for (Row& row : on_gpu) row["device"]["type"] = "discrete";
  EXPECT_THAT(notes_of(make_table(spec_, config_, results_of(on_gpu))),
              testing::Not(testing::Contains(HasSubstr("not comparable"))));
}

TEST_F(RenderTable, PicturesAndVoxelsAreNotMixed) {
  spec_.pivot.reset();
  spec_.columns = {"frame_ms"};
  EXPECT_EQ(make_table(spec_, config_, results_of(rows())).lines.size(), 8u);
  spec_.rows = {"dataset", "codec"};
  spec_.columns = {"encode_seconds"};
  EXPECT_EQ(make_table(spec_, config_, results_of(rows())).lines.size(), 2u);
}

TEST(PublishedFrames, EveryFigureNamesWhatThisBuildHas) {
  const std::string path = std::string(CVR_SOURCE_DIR) + "/results/published/csgvr.yaml";
  const PublishedTable table4 = load_published(path, "table4"),
                       s1 = load_published(path, "table_s1");
  // Table 4: 9 lines, Table S1: 17, of 12 figures each; without stop bits and as nibbles H01 does
  // not fit.
  EXPECT_EQ(table4.figures.size(), 9u * 12 - 4 * 3);
  EXPECT_EQ(s1.figures.size(), 17u * 12 - 11 * 3);
  for (const PublishedFigure& figure : s1.figures) {
    EXPECT_NE(codecs::find_codec(figure.codec), nullptr) << figure.codec;
    EXPECT_NE(gpu::find_cache(figure.access_mode), nullptr) << figure.access_mode;
    EXPECT_TRUE(gpu::shading_from_name(figure.shading)) << figure.shading;
    EXPECT_TRUE(figure.frame_ms.has_value());
  }
  EXPECT_THAT(s1.hardware, HasSubstr("RTX 4070 Ti Super"));
  EXPECT_THAT(load_published(path, "table2").hardware, testing::Not(HasSubstr("RTX")));
  const PublishedTable of_any_brick = load_published(path, "table_s1", {"brick"});
  const PublishedTable* table = &s1;
  const auto figure_of = [&](const char* dataset, const char* codec, const char* brick,
                             const char* cache, gpu::Shading shading) {
    auto described = std::make_shared<Dataset>();
    described->name = dataset;
    Cell cell{described, codec, 1, {}, stage("render"), {"all", 2}, RenderChoice{}};
    const std::string assignment = std::string("brick=") + brick;
    cell.parameters = codecs::Parameters::parse(codecs::find_codec(codec)->parameters(),
                                                std::span(&assignment, 1))
                          .value();
    cell.render->access = cache;
    cell.render->shading = shading;
    const PublishedFigure* found = table->find(cell);
    return found == nullptr ? -1 : *found->frame_ms;
  };
  EXPECT_EQ(figure_of("cells", "csgvr-sb", "32", "voxel", gpu::Shading::kLocal), 9.7);
  EXPECT_EQ(figure_of("h01", "csgvr-sb", "64", "voxel-es", gpu::Shading::kAo), 109.1);
  EXPECT_EQ(figure_of("azba", "csgv-rans", "32", "brick", gpu::Shading::kShadow), 12.4);
  EXPECT_EQ(figure_of("h01", "csgvr-sb", "32", "voxel", gpu::Shading::kAo), -1)
      << "the paper's H01 has bricks of 64^3";
  table = &of_any_brick;
  EXPECT_EQ(figure_of("h01", "csgvr-sb", "32", "voxel", gpu::Shading::kAo), 1.8);
}

}  // namespace
}  // namespace cvr::experiments
