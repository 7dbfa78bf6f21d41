// Markers: each kind of figure from hand-made rows, what stands around them, and mistakes.
#include "experiments/analysis/markers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/analysis/metrics.hpp"
#include "experiments/run/load_config.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "tests/unit/experiments/results_of.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kConfig = R"(title: T
rounds: 1
matrix:
  - datasets: [{generator: cells, extent: [8, 8, 8], name: a}, {generator: cells, extent: [9, 9, 9], name: b}]
    codecs: [raw, zstd]
    stages: [encode]
tables:
  - {name: sizes, title: Sizes, rows: [dataset, codec], columns: [bits_per_voxel], where: {codec: [raw, zstd]}}
claims:
  - {name: small, says: "zstd is small", source: P, metric: bits_per_voxel, left: {codec: zstd}, each: [dataset], at_most: 5}
  - {name: beauty, says: "it is beautiful", source: P, not_testable: "nobody measures that"}
)";

class MarkersTest : public testing::Test {
 protected:
  MarkersTest() {
    evidence_.name = "run";
    evidence_.config = load_config(folder_.write("c.yaml", kConfig), Catalogue(), {});
    std::vector<Row> rows;
    double bits = 1;
    for (const Cell& cell : evidence_.config.cells) {
      if (cell.codec == kMemcpy) continue;
      Row row{{"cell", "id-" + cell.dataset->name + "-" + cell.codec},
              {"key", cell.row_key()},
              {"status", "ok"},
              {"reason", ""}};
      row["size"] = {{"bits_per_voxel", bits *= 2}, {"rate", 100 / bits}};
      row["verification"] = {{"voxels_compared", 512}, {"mismatches", 0}};
      rows.push_back(row);
    }
    evidence_.rows = results_of(rows);
    evidence_.readme = "# A run\n";
  }

  std::string filled(const std::string& text) {
    return fill_markers(
        "d.md", text,
        [&](const std::string& name) -> const Evidence& {
          if (name != "run") throw volumes::InputError("expected the run, found " + name);
          return evidence_;
        },
        metric_names());
  }
  /// What stands between the markers.
  std::string figure(const std::string& body) {
    const std::string text = filled("<!--cvrbench {run: run, " + body + "}-->old<!--/cvrbench-->");
    const std::size_t begin = text.find("-->") + 3;
    return text.substr(begin, text.rfind("<!--") - begin);
  }
  std::string error(const std::string& text) {
    try {
      filled(text);
    } catch (const volumes::InputError& e) {
      return e.what();
    }
    return "no error";
  }
  std::string error_of(const std::string& body) {
    return error("\n<!--cvrbench {run: run, " + body + "}--><!--/cvrbench-->");
  }

  ScratchFolder folder_;
  Evidence evidence_;
};

/// Bits per voxel of the cells: a raw, a zstd, b raw, b zstd, each twice the one before or more.
TEST_F(MarkersTest, FiguresAreThoseOfTables) {
  const std::string a = figure("value: bits_per_voxel, where: {dataset: a, codec: raw}"),
                    b = figure("value: bits_per_voxel, where: {dataset: b, codec: zstd}");
  EXPECT_THAT(figure("table: sizes"), HasSubstr("| a       | raw   |     " + a + " |\n"));
  EXPECT_EQ(figure("least: bits_per_voxel"), a);
  EXPECT_EQ(figure("largest: bits_per_voxel"), b);
  EXPECT_EQ(figure("range: bits_per_voxel"), a + " to " + b);
  EXPECT_EQ(figure("value: bits_per_voxel, where: {dataset: a, codec: raw}, decimals: 0"),
            a.substr(0, a.find('.')));
  EXPECT_EQ(figure("value: bits_per_voxel, where: {dataset: b, codec: zstd}, over: {dataset: b, "
                   "codec: raw}"),
            "2.00");
  EXPECT_EQ(figure("cells: ok"), "4");
  EXPECT_EQ(figure("cells: ok, where: {codec: zstd}"), "2");
  EXPECT_EQ(figure("cells: failed"), "0");
}

TEST_F(MarkersTest, TablesStandOnLinesOfTheirOwnWithoutTitleAndNotes) {
  const std::string sizes = figure("table: sizes, where: {dataset: b}");
  EXPECT_THAT(sizes, StartsWith("\n| dataset | codec |"));
  EXPECT_EQ(std::ranges::count(sizes, '\n'), 5);
  EXPECT_EQ(sizes.back(), '\n');
  EXPECT_EQ(figure("rows: [dataset, codec], columns: [bits_per_voxel], where: {dataset: b, codec: "
                   "[raw, zstd]}"),
            sizes);
  EXPECT_THAT(figure("rows: [dataset], pivot: {columns: [codec], metric: bits_per_voxel}, where: "
                     "{codec: [raw, zstd]}"),
              StartsWith("\n| dataset |    raw |"));
}

TEST_F(MarkersTest, Claims) {
  EXPECT_EQ(figure("claim: small"), "does not hold");
  EXPECT_EQ(figure("claim: beauty"), "not testable here");
  const std::string all = figure("claims: [all]");
  EXPECT_THAT(all, HasSubstr("| zstd is small (P)   | does not hold     | 1 / 1 / 0 | 4 .. 16"));
  EXPECT_THAT(all, HasSubstr("| it is beautiful (P) | not testable here |           | nobody"));
  EXPECT_EQ(figure("claims: [small, beauty]"), all);
}

TEST_F(MarkersTest, TheRestOfATextStays) {
  const std::string before = "A `<!--cvrbench {run` b.\n```\n<!--cvrbench {run: none\n```\n",
                    after = "\n\nend <!-- other -->";
  const std::string marker = "<!--cvrbench\nrun: run\ncells: ok\n-->";
  EXPECT_EQ(filled(before + marker + "x<!--/cvrbench-->" + after),
            before + marker + "4<!--/cvrbench-->" + after);
  EXPECT_EQ(filled("none at all"), "none at all");
  const std::string once = filled(before + marker + "<!--/cvrbench-->" + after);
  EXPECT_EQ(filled(once), once);
}

TEST_F(MarkersTest, MistakesAreToldWithTheirPlace) {
  EXPECT_EQ(error("\n\n<!--cvrbench {run: run, cells: ok}-->"),
            "d.md:3: marker: expected <!--/cvrbench--> behind it, found none");
  EXPECT_THAT(error("<!--cvrbench {run: run, cells: ok}--> <!--cvrbench {}--><!--/cvrbench-->"),
              HasSubstr("behind it"));
  EXPECT_THAT(error_of("cells: ok, sum: rate"), HasSubstr("found several"));
  EXPECT_THAT(error_of("where: {codec: raw}"), HasSubstr("expected one of the keys value, least"));
  EXPECT_THAT(error_of("value: rat"), StartsWith("d.md:2: marker:1:"));
  EXPECT_THAT(error_of("value: rate"),
              HasSubstr("d.md:2: marker of run: expected one rate, found 4"));
  EXPECT_THAT(error_of("value: decode_seconds, where: {dataset: a}"),
              HasSubstr("expected a decode_seconds that it has, found none"));
  EXPECT_THAT(error_of("table: none"), HasSubstr("expected a table of it, found none"));
  EXPECT_THAT(error_of("claim: none"), HasSubstr("expected a claim of it, found none"));
  EXPECT_THAT(error("<!--cvrbench {run: other, cells: ok}--><!--/cvrbench-->"),
              HasSubstr("d.md:1: marker of other: expected the run"));
}

TEST_F(MarkersTest, APageHoldsTablesClaimsAndTheIdsOfRows) {
  const std::string page = evidence_page(evidence_);
  EXPECT_THAT(page, StartsWith("# A run\n"));
  EXPECT_THAT(page, HasSubstr("\n## Sizes\n\n| dataset |"));
  EXPECT_THAT(page, HasSubstr("\n## Claims: T\n"));
  EXPECT_THAT(page, HasSubstr("| small  | b     | does not hold     | 16"));
  EXPECT_THAT(page, HasSubstr("| id-b-zstd |"));
  EXPECT_THAT(page, testing::Not(HasSubstr("## Figures")));
  EXPECT_THAT(evidence_page(evidence_, {"figures/run/rates.svg"}),
              HasSubstr("\n## Figures\n\n![figures/run/rates.svg](figures/run/rates.svg)\n"));
}

}  // namespace
}  // namespace cvr::experiments
