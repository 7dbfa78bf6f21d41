// Tables of hand-made rows, as they must read, in all formats.
#include "experiments/analysis/tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codecs/registry.hpp"
#include "experiments/analysis/metrics.hpp"
#include "experiments/analysis/table_formats.hpp"
#include "experiments/config/published.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "tests/unit/experiments/results_of.hpp"
#include "tests/unit/experiments/stage.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

class TableTest : public testing::Test {
 protected:
  TableTest() {
    auto dataset = std::make_shared<Dataset>();
    dataset->name = "blob";
    dataset->stand_in_for = "big";
    dataset->extent = {10, 20, 30};
    const auto* codec = codecs::find_codec("csgv-nibble");
    for (const std::string& codec_id : {std::string(kMemcpy), std::string("csgv-nibble")}) {
      for (const char* id : {"encode", "random-access"}) {
        if (codec_id == kMemcpy && id == std::string_view("random-access")) continue;
        Cell cell{dataset, codec_id, 1, {}, stage(id), {}};
        cell.threads = {"1", 1};
        if (codec_id != kMemcpy)
          cell.parameters = codecs::Parameters::parse(codec->parameters(), {}).value();
        config_.cells.push_back(cell);
      }
    }
    spec_.name = "t";
    spec_.title = "Title";
    spec_.rows = {"dataset", "codec", "brick"};
    spec_.columns = {"published_rate", "published",         "ratio",
                     "encode_seconds", "access_uniform_ns", "exact"};
    const std::string published = folder_.write(
        "p.yaml",
        "citation: C\ntables:\n  t2:\n    title: T2\n    figures:\n"
        "      - {dataset: big, codec: csgv-nibble, parameters: {brick: 64}, rate: 9}\n"
        "      - {dataset: big, codec: csgv-nibble, parameters: {brick: 32}, rate: 2.5}\n");
    spec_.published = {published, "t2"};
  }

  std::vector<Row> rows() const {
    std::vector<Row> rows;
    for (const Cell& cell : config_.cells) {
      Row row{{"cell", cell.row_key()}, {"key", cell.row_key()}, {"status", "ok"}, {"reason", ""}};
      if (cell.stage->id == "encode") row["time"]["seconds"]["median"] = 0.125;
      if (cell.codec != kMemcpy && cell.stage->id == "encode") {
        row["size"]["published_rate"] = 2.0;
        row["verification"] = {{"voxels_compared", 6000}, {"mismatches", 0}};
      }
      if (cell.stage->id == "random-access") {
        row["status"] = "unsupported";
        row["reason"] = "no access, \"none\"";
      }
      rows.push_back(row);
    }
    return rows;
  }

  ScratchFolder folder_;
  Config config_;
  TableSpec spec_;
};

TEST_F(TableTest, Markdown) {
  EXPECT_EQ(render(make_table(spec_, config_, results_of(rows())), TableFormat::kMarkdown),
            "### Title\n\n"
            "| dataset | codec       | brick | rate % | published % | ours/published | encode s |  "
            " access "
            "ns |            exact |\n"
            "|:--------|:------------|:------|-------:|------------:|---------------:|---------:|--"
            "----------"
            ":|-----------------:|\n"
            "| blob    | memcpy      |       |        |             |                |    0.125 |  "
            "          "
            " |                  |\n"
            "| blob    | csgv-nibble | 32    |  2.000 |       2.500 |          0.800 |    0.125 | "
            "unsupported | 0 of 6000 differ |\n"
            "\n"
            "- Columns: **rate %** bytes by the accounting of the papers' tables / bytes of the "
            "original by the same, "
            "in percent; **published %** the rate that the publication states, in percent; "
            "**ours/published** "
            "published_rate measured here / rate published; **encode s** median wall time of "
            "encoding, file reading and "
            "writing apart; **access ns** median ns per voxel, uniform points, finest level; "
            "**exact** voxels of the decoded "
            "volume that differ from the original.\n"
            "- Published: C; T2.\n"
            "- random-access unsupported: no access, \"none\" (csgv-nibble)\n");
}

TEST_F(TableTest, Csv) {
  EXPECT_EQ(render(make_table(spec_, config_, results_of(rows())), TableFormat::kCsv),
            "dataset,codec,brick,rate %,published %,ours/published,encode s,access ns,exact\n"
            "blob,memcpy,,,,,0.125,,\n"
            "blob,csgv-nibble,32,2.000,2.500,0.800,0.125,unsupported,0 of 6000 differ\n");
}

TEST_F(TableTest, LatexEscapes) {
  const std::string text =
      render(make_table(spec_, config_, results_of(rows())), TableFormat::kLatex);
  EXPECT_THAT(text, testing::HasSubstr("\\begin{tabular}{lllrrrrrr}\n"));
  EXPECT_THAT(text, testing::HasSubstr("rate \\% & published \\%"));
  EXPECT_THAT(text, testing::HasSubstr("blob & csgv-nibble & 32 & 2.000 & 2.500 & 0.800 & 0.125 & "
                                       "unsupported & 0 of 6000 differ \\\\\n"));
}

TEST_F(TableTest, AFailedCellHasItsStatusInsteadOfFigures) {
  auto failed = rows();
  failed[1]["status"] = "failed";
  failed[1]["reason"] = "3 of 6000 decoded voxels differ from the original";
  const std::string text =
      render(make_table(spec_, config_, results_of(failed)), TableFormat::kCsv);
  EXPECT_THAT(text, testing::HasSubstr("csgv-nibble,32,failed,2.500,,failed,unsupported"));
}

TEST_F(TableTest, CellsThatWereNotRunAreNamed) {
  const Table table = make_table(spec_, config_, {});
  EXPECT_EQ(table.lines.size(), 2u);
  EXPECT_EQ(table.notes.back().plain(), "3 cells have not been run.");
}

TEST_F(TableTest, ConditionsTakeLinesAwayButKeepMemcpy) {
  spec_.where = {{"brick", "64"}};
  const Table table = make_table(spec_, config_, results_of(rows()));
  ASSERT_EQ(table.lines.size(), 1u);
  EXPECT_EQ(table.lines[0].cells[1].text, "memcpy");
}

TEST_F(TableTest, JsonHoldsTheNumbersBehindTheTexts) {
  spec_.columns = {"published_rate", "encode_seconds", "exact", "pareto"};
  auto measured = rows();
  measured[1]["time"]["seconds"]["samples"] = {0.25, 0.125, 0.0625};
  measured[1]["time"]["seconds"]["interval"] = {0.0625, 0.25};
  measured[1]["size"]["published_rate"] = 2.00049;
  measured[1]["size"]["bits_per_voxel"] = 0.5;
  const Row table =
      Row::parse(render(make_table(spec_, config_, results_of(measured)), TableFormat::kJson));
  EXPECT_EQ(table["schema"], 1);
  EXPECT_EQ(table["name"], "t");
  EXPECT_EQ(table["title"], "Title");
  EXPECT_EQ(table["labels"], 3);
  EXPECT_EQ(table["columns"][1].dump(),
            R"({"name":"codec","heading":"codec","unit":"","description":"","align":"left"})");
  EXPECT_EQ(table["columns"][4].dump(),
            R"({"name":"encode_seconds","heading":"encode s","unit":"s","description":)"
            R"("median wall time of encoding, file reading and writing apart","align":"right"})");
  ASSERT_EQ(table["lines"].size(), 2u);
  const Row& line = table["lines"][1];
  EXPECT_EQ(line["cells"][1].dump(), R"({"text":"csgv-nibble"})");
  EXPECT_EQ(line["cells"][3].dump(),
            R"({"text":"2.000","number":2.00049,"published":{"text":"2.500","number":2.5}})");
  EXPECT_EQ(line["cells"][4].dump(), R"({"text":"0.125","number":0.125,"interval":[0.0625,0.25]})");
  EXPECT_EQ(line["cells"][5].dump(), R"({"text":"0 of 6000 differ","number":0.0})");
  EXPECT_EQ(line["cells"][6].dump(), R"({"text":"*"})");
  EXPECT_EQ(line["fronts"].dump(), R"(["pareto"])");
  EXPECT_EQ(table["lines"][0]["fronts"].dump(), "[]");
  EXPECT_EQ(table["published"].dump(), R"({"citation":"C","title":"T2","hardware":""})");
  EXPECT_EQ(table["notes"].back(), "random-access unsupported: no access, \"none\" (csgv-nibble)");
}

TEST_F(TableTest, TextFromOutsideIsEscapedInEachFormat) {
  spec_.title = "T*\n#";
  auto hostile = rows();
  hostile[2]["reason"] = "a `b` <c>\n- d\x1b[2J";
  const Table table = make_table(spec_, config_, results_of(hostile));
  EXPECT_THAT(render(table, TableFormat::kMarkdown),
              testing::AllOf(testing::StartsWith("### T\\*\\n#\n"),
                             testing::HasSubstr("a \\`b\\` \\<c>\\n- d\\x1b[2J (csgv-nibble)\n")));
  const std::string latex = render(table, TableFormat::kLatex);
  EXPECT_THAT(latex, testing::StartsWith("% T*\\n#\n"));
  EXPECT_THAT(latex, testing::HasSubstr("\\<c>\\n- d\\x1b[2J (csgv-nibble)\n"));
  const Row json = Row::parse(render(table, TableFormat::kJson));
  EXPECT_EQ(json["title"], "T*\\n#");
  EXPECT_EQ(json["notes"].back(),
            "random-access unsupported: a `b` <c>\\n- d\\x1b[2J (csgv-nibble)");
}

TEST(Columns, HeadingsNameTheirUnit) {
  EXPECT_EQ(unit_in("access ns, level 3"), "ns");
  EXPECT_EQ(unit_in("rate % gzip -6"), "%");
  EXPECT_EQ(unit_in("encode +-%"), "%");
  EXPECT_EQ(unit_in("path; held ms"), "ms");
  EXPECT_EQ(unit_in("front"), "");
  EXPECT_EQ(unit_in("labels"), "");
  EXPECT_EQ(unit_in(""), "");
  EXPECT_EQ(unit_in(find_metric("step_ms")->heading), "ms");
  EXPECT_EQ(unit_in(find_metric("gpu_bits_per_voxel")->heading), "bits/voxel");
}

TEST(Published, TheFiguresOfThePaperAreCarriedWhole) {
  const std::string path = std::string(CVR_SOURCE_DIR) + "/results/published/csgvr.yaml";
  EXPECT_EQ(load_published(path, "table2").figures.size(), 4u * 3 * 4);
  EXPECT_EQ(load_published(path, "table3").figures.size(), 4u * 7);
  EXPECT_THROW(load_published(path, "table9"), volumes::InputError);
}

}  // namespace
}  // namespace cvr::experiments
