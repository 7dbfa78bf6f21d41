// Claims: each verdict, each form, at the edges of bounds, intervals and tolerances; and mistakes
// in their YAML.
#include "experiments/analysis/claims.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "experiments/analysis/table_formats.hpp"
#include "experiments/results/measured.hpp"
#include "experiments/run/load_config.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "tests/unit/experiments/results_of.hpp"
#include "tests/unit/experiments/stage.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kMatrix = R"(title: T
rounds: 1
matrix:
  - datasets: [{generator: shells, extent: [8, 8, 8], name: a}, {generator: shells, extent: [8, 8, 8], name: b}]
    codecs: [{id: zfp, parameters: {block_bits: [32, 64, 128, 256]}}, {id: tvq, parameters: {rate: [300, 400, 550, 750]}}, bc4]
    stages: [encode, decode]
  - datasets: [{generator: cells, extent: [8, 8, 8], name: d}]
    codecs: [raw]
    stages: [render]
    scenes: [cells]
    access_modes: [none, voxel]
    shadings: [local]
claims:
  - {name: c, says: S, source: P, )";
constexpr std::size_t kClaimLine = 14;

/// Sets what a row has beside its identity.
using Fill = std::function<void(const Cell&, Row&)>;

class ClaimsTest : public testing::Test {
 protected:
  Config load(const std::string& keys) {
    folder_.write("p.yaml",
                  "citation: C\ntables:\n  t:\n    title: T\n    figures:\n      - {dataset: a, "
                  "codec: bc4, rate: 40}\n");
    return load_config(folder_.write("c.yaml", kMatrix + keys + "}\n"), Catalogue(), {});
  }
  std::vector<Row> rows(const Fill& fill) {
    std::vector<Row> rows;
    for (const Cell& cell : config_.cells) {
      Row row{{"cell", cell.row_key()}, {"key", cell.row_key()}, {"status", "ok"}, {"reason", ""}};
      fill(cell, row);
      if (row["status"] != "absent") rows.push_back(row);
    }
    return rows;
  }
  ClaimVerdict judge(const std::string& keys, const Fill& fill) {
    config_ = load(keys);
    verdicts_ = judge_claims(config_, results_of(rows(fill)));
    return verdicts_.front();
  }
  /// Of the first group.
  Verdict verdict(const std::string& keys, const Fill& fill) {
    return judge(keys, fill).groups.front().verdict;
  }
  std::string error(const std::string& keys) {
    try {
      load(keys);
    } catch (const volumes::InputError& e) {
      const std::string what = e.what();
      return what.substr(std::min(what.find("c.yaml"), what.size()));
    }
    return "no error";
  }

  ScratchFolder folder_;
  Config config_;
  std::vector<ClaimVerdict> verdicts_;
};

/// 30 dB at 1 bit per voxel and 6 dB more for each doubling, of tvq `gain` dB more; bc4 has 4 bits.
Fill lossy(double gain) {
  return [gain](const Cell& cell, Row& row) {
    if (cell.codec == kMemcpy || cell.render) return;
    row["verification"] = {{"voxels_compared", 512}, {"mismatches", 7}};
    double bits = 4;
    if (cell.codec == "zfp") bits = std::stod(cell.parameters.values().at("block_bits")) / 64;
    if (cell.codec == "tvq") bits = std::stod(cell.parameters.values().at("rate")) / 400;
    row["size"] = {{"bits_per_voxel", bits}, {"published_rate", 12.5 * bits}};
    row["error"]["psnr_db"] = 30 + 6 * std::log2(bits) + (cell.codec == "tvq" ? gain : 0);
  };
}

/// Seconds of encoding, one after the other: `right` of bc4, `left` of all others.
Fill times(const std::vector<double>& left, const std::vector<double>& right) {
  return [=](const Cell& cell, Row& row) {
    if (cell.stage->id != "encode") return;
    const auto& samples = cell.codec == "bc4" ? right : left;
    if (samples.empty()) return;
    double sum = 0;
    for (const double s : samples) sum += s;
    const Repeated seconds = describe_samples(samples);
    row["time"]["seconds"] = {{"median", sum / static_cast<double>(samples.size())},
                              {"interval", seconds.interval},
                              {"samples", samples}};
    row["time"]["mvoxel_per_s"] = static_cast<double>(samples.size()) / sum;
  };
}

const std::string kPair =
    "left: {codec: zfp, block_bits: 64}, right: {codec: bc4}, each: [dataset], ";

TEST_F(ClaimsTest, ExactFiguresAreComparedWithBothBounds) {
  const std::string ratio = kPair + "metric: bits_per_voxel, compare: ratio, ";
  EXPECT_EQ(verdict(ratio + "at_most: 0.25", lossy(0)), Verdict::kHolds);
  EXPECT_EQ(verdict(ratio + "at_most: 0.24", lossy(0)), Verdict::kDoesNotHold);
  EXPECT_EQ(verdict(ratio + "at_least: 0.25", lossy(0)), Verdict::kHolds);
  EXPECT_EQ(verdict(ratio + "at_least: 0.26", lossy(0)), Verdict::kDoesNotHold);
  EXPECT_EQ(verdict(ratio + "at_least: 0.2, at_most: 0.3", lossy(0)), Verdict::kHolds);
  const std::string difference = kPair + "metric: volume_psnr_db, compare: difference, ";
  EXPECT_EQ(verdict(difference + "at_least: -12, at_most: -12", lossy(0)), Verdict::kHolds);
  EXPECT_EQ(verdict(difference + "at_least: -11", lossy(0)), Verdict::kDoesNotHold);
  const ClaimVerdict all = judge(difference + "at_most: -2", lossy(0));
  ASSERT_EQ(all.groups.size(), 2u);
  EXPECT_THAT(all.groups[1].labels, ElementsAre("b"));
  EXPECT_EQ(all.groups[1].reason, "30 - 42 = -12");
  EXPECT_DOUBLE_EQ(all.groups[1].compared.at(0).value, -12);
}

TEST_F(ClaimsTest, ToleranceWidensTheBoundsAndNoMore) {
  const std::string pair =
      kPair + "metric: volume_psnr_db, compare: difference, at_least: -11.95, tolerance: ";
  EXPECT_EQ(verdict(pair + "0.05", lossy(0)), Verdict::kHolds) << "decimal figures at the bound";
  EXPECT_EQ(verdict(pair + "0.0499", lossy(0)), Verdict::kDoesNotHold);
  EXPECT_EQ(
      verdict(
          kPair + "metric: volume_psnr_db, compare: difference, at_most: -12.05, tolerance: 0.05",
          lossy(0)),
      Verdict::kHolds);
  EXPECT_EQ(
      verdict(
          kPair + "metric: volume_psnr_db, compare: difference, at_most: -12.05, tolerance: 0.04",
          lossy(0)),
      Verdict::kDoesNotHold);
}

TEST_F(ClaimsTest, AFigureAloneANumberAndAPublishedFigure) {
  const std::string left = "left: {codec: bc4}, each: [dataset], metric: published_rate, ";
  EXPECT_EQ(verdict(left + "at_least: 50, at_most: 50", lossy(0)), Verdict::kHolds);
  EXPECT_EQ(verdict(left + "at_least: 50.01", lossy(0)), Verdict::kDoesNotHold);
  EXPECT_EQ(verdict(left + "value: 40, compare: ratio, at_least: 1.25, at_most: 1.25", lossy(0)),
            Verdict::kHolds);
  EXPECT_EQ(verdict(left + "value: 40, compare: difference, at_most: 9", lossy(0)),
            Verdict::kDoesNotHold);
  const ClaimVerdict published =
      judge(left + "published: {file: p.yaml, table: t}, compare: ratio, at_most: 1.2", lossy(0));
  EXPECT_EQ(published.groups[0].reason, "50 / 40 = 1.25");
  EXPECT_EQ(published.groups[0].verdict, Verdict::kDoesNotHold);
  EXPECT_EQ(published.groups[1].verdict, Verdict::kUnchecked);
  EXPECT_EQ(published.groups[1].reason, "no figure is published");
  EXPECT_EQ(published.verdict, Verdict::kDoesNotHold) << "by the group that could be checked";
}

TEST_F(ClaimsTest, TimesHoldFailOrStayUndecidedByTheirIntervals) {
  const std::string faster =
      "where: {dataset: a}, left: {codec: tvq, rate: 300}, right: {codec: bc4}, metric: "
      "encode_seconds, compare: ratio, at_most: 1";
  EXPECT_EQ(verdict(faster, times({1, 1.1, 1.2}, {2, 2.1, 2.2})), Verdict::kHolds);
  EXPECT_EQ(verdict(faster, times({3, 3.1, 3.2}, {2, 2.1, 2.2})), Verdict::kDoesNotHold);
  EXPECT_EQ(verdict(faster, times({1, 1.1, 2.05}, {2, 2.1, 2.2})), Verdict::kUndecided)
      << "the intervals overlap";
  EXPECT_EQ(verdict(faster, times({1, 1.1, 2}, {2, 2.1, 2.2})), Verdict::kHolds)
      << "they touch at the bound";
  EXPECT_EQ(verdict(faster, times({1, 1}, {2, 2})), Verdict::kUndecided)
      << "two repetitions have no interval";
  const ClaimVerdict two = judge(faster, times({1, 1}, {2, 2}));
  EXPECT_THAT(two.groups[0].reason, HasSubstr("repeated fewer than 3 times"));
  EXPECT_FALSE(two.groups[0].compared.at(0).interval);
  const ClaimVerdict three = judge(faster, times({1, 1.5, 2}, {4, 5, 6}));
  EXPECT_DOUBLE_EQ(three.groups[0].compared.at(0).interval->low, 1.0 / 6);
  EXPECT_DOUBLE_EQ(three.groups[0].compared.at(0).interval->high, 0.5);
  EXPECT_EQ(three.groups[0].reason, "1.5 [1, 2] / 5 [4, 6] = 0.3 [0.1667, 0.5]");
  const std::string speed =
      "where: {dataset: a}, left: {codec: tvq, rate: 300}, right: {codec: bc4}, metric: "
      "encode_mvoxel_per_s, compare: ratio, at_least: ";
  EXPECT_EQ(verdict(speed + "2", times({1, 1.5, 2}, {4, 5, 6})), Verdict::kHolds)
      << "a speed has the inverted interval";
  EXPECT_EQ(verdict(speed + "2.1", times({1, 1.5, 2}, {4, 5, 6})), Verdict::kUndecided);
  EXPECT_EQ(verdict(speed + "6.1", times({1, 1.5, 2}, {4, 5, 6})), Verdict::kDoesNotHold);
}

TEST_F(ClaimsTest, AClockThatStandsStillHasNoRatio) {
  const std::string ratio =
      "where: {dataset: a}, left: {codec: tvq, rate: 300}, right: {codec: bc4}, metric: "
      "encode_seconds, compare: ratio, at_most: 1";
  const ClaimVerdict still = judge(ratio, times({1, 1, 1}, {0, 0, 1}));
  EXPECT_EQ(still.groups[0].verdict, Verdict::kUnchecked);
  EXPECT_THAT(still.groups[0].reason, HasSubstr("has no ratio"));
}

TEST_F(ClaimsTest, OrdersAreAscending) {
  const Fill frames = [](const Cell& cell, Row& row) {
    if (!cell.render) return;
    const double ms = cell.render->access == "none" ? 20 : 5;
    row["held"] = {{"median_ms", ms}, {"ms", {{99, 99}, {ms, ms + 1}, {ms, ms - 1}}}};
  };
  EXPECT_EQ(
      verdict("metric: warm_ms, compare: ratio, order: [{cache: voxel}, {cache: none}]", frames),
      Verdict::kHolds);
  EXPECT_EQ(
      verdict("metric: warm_ms, compare: ratio, order: [{cache: none}, {cache: voxel}]", frames),
      Verdict::kDoesNotHold);
  EXPECT_EQ(
      verdict(
          "metric: warm_ms, compare: ratio, tolerance: 0.9, order: [{cache: none}, {cache: voxel}]",
          frames),
      Verdict::kHolds)
      << "a quarter is within one tenth of as much";
  const std::string rates =
      "where: {dataset: b, codec: zfp}, metric: bits_per_voxel, compare: difference, order: ";
  EXPECT_EQ(verdict(rates + "[{block_bits: 32}, {block_bits: 64}, {block_bits: 256}]", lossy(0)),
            Verdict::kHolds);
  const ClaimVerdict wrong =
      judge(rates + "[{block_bits: 32}, {block_bits: 256}, {block_bits: 128}]", lossy(0));
  EXPECT_EQ(wrong.verdict, Verdict::kDoesNotHold);
  EXPECT_EQ(wrong.groups[0].reason, "4 - 0.5 = 3.5; 2 - 4 = -2");
  EXPECT_EQ(wrong.groups[0].compared.size(), 2u);
  EXPECT_EQ(verdict(rates + "[{block_bits: 256}, {block_bits: 128}]", lossy(0)),
            Verdict::kDoesNotHold);
}

TEST_F(ClaimsTest, CurvesAreComparedWhereTheyOverlap) {
  const std::string curves =
      "left: {codec: tvq}, right: {codec: zfp}, each: [dataset], metric: volume_psnr_db, over: "
      "bits_per_voxel, compare: difference, ";
  EXPECT_EQ(verdict(curves + "at_least: 2, at_most: 4", lossy(3)), Verdict::kHolds);
  EXPECT_EQ(verdict(curves + "at_least: 2, at_most: 4", lossy(1.5)), Verdict::kDoesNotHold);
  EXPECT_EQ(verdict(curves + "at_least: 2, at_most: 4", lossy(4.5)), Verdict::kDoesNotHold);
  const ClaimVerdict found = judge(curves + "at_least: 2", lossy(3));
  EXPECT_NEAR(found.groups[0].compared.at(0).value, 3, 1e-9)
      << "straight lines over the logarithm, 3 dB apart";
  EXPECT_EQ(found.groups[0].reason, "+3.00 dB over 0.750 .. 1.875");
  const ClaimVerdict apart = judge(curves + "at_least: 2", [](const Cell& cell, Row& row) {
    lossy(3)(cell, row);
    if (cell.codec == "tvq")
      row["size"]["bits_per_voxel"] = 100 * row["size"]["bits_per_voxel"].get<double>();
  });
  EXPECT_EQ(apart.verdict, Verdict::kUnchecked);
  EXPECT_THAT(apart.groups[0].reason, HasSubstr("expected rates in common"));
}

TEST_F(ClaimsTest, WhatDoesNotExistCannotBeChecked) {
  const std::string claim = kPair + "metric: bits_per_voxel, compare: ratio, at_most: 1";
  for (const auto& [status, reason] : std::vector<std::pair<std::string, std::string>>{
           {"failed", "bc4 encode: failed (why)"},
           {"data-missing", "bc4 encode: data-missing (why)"},
           {"unsupported", "bc4 encode: unsupported (why)"},
           {"absent", "bc4 has not been run"}}) {
    const ClaimVerdict missing = judge(claim, [&, bad = status](const Cell& cell, Row& row) {
      lossy(0)(cell, row);
      if (cell.codec != "bc4" || cell.dataset->name != "a") return;
      row["status"] = bad;
      row["reason"] = "why";
    });
    EXPECT_EQ(missing.groups[0].verdict, Verdict::kUnchecked) << status;
    EXPECT_EQ(missing.groups[0].reason, reason);
    EXPECT_TRUE(missing.groups[0].compared.empty());
    EXPECT_EQ(missing.groups[1].verdict, Verdict::kHolds);
    EXPECT_EQ(missing.verdict, Verdict::kHolds);
  }
  const ClaimVerdict none = judge(claim, [](const Cell&, Row&) {});
  EXPECT_EQ(none.verdict, Verdict::kUnchecked);
  EXPECT_EQ(none.groups[0].reason, "zfp defaults has no bits_per_voxel");
}

TEST_F(ClaimsTest, AnExactVolumeHasAnInfinitePsnr) {
  const auto exact = [](const std::string& codecs) {
    return [codecs](const Cell& cell, Row& row) {
      lossy(0)(cell, row);
      if (!row.contains("error") || codecs.find(cell.codec) == std::string::npos) return;
      row["error"]["psnr_db"] = nullptr;
      row["verification"]["mismatches"] = 0;
    };
  };
  const std::string claim = kPair + "metric: volume_psnr_db, compare: difference, at_least: 1";
  EXPECT_EQ(verdict(claim, exact("zfp")), Verdict::kHolds);
  EXPECT_EQ(verdict(claim, exact("bc4")), Verdict::kDoesNotHold);
  EXPECT_EQ(verdict(claim, exact("zfp bc4")), Verdict::kUnchecked)
      << "the difference of two infinities";
}

TEST_F(ClaimsTest, AllMostOrSomeGroupsDecideTheClaim) {
  const std::string claim =
      "left: {codec: zfp}, right: {codec: bc4}, each: [dataset, block_bits], metric: "
      "bits_per_voxel, compare: ratio, ";
  EXPECT_THAT(error(claim + "at_most: 1"),
              HasSubstr("expected cells that match in the group a 32, found none"));
  const std::string own =
      "left: {codec: zfp}, each: [dataset, block_bits], metric: bits_per_voxel, ";
  EXPECT_EQ(judge(own + "at_most: 2", lossy(0)).verdict, Verdict::kDoesNotHold);
  EXPECT_EQ(judge(own + "at_most: 2, holds_in: most", lossy(0)).verdict, Verdict::kHolds);
  EXPECT_EQ(judge(own + "at_most: 1, holds_in: most", lossy(0)).verdict, Verdict::kDoesNotHold)
      << "half is not most";
  EXPECT_EQ(judge(own + "at_most: 0.5, holds_in: some", lossy(0)).verdict, Verdict::kHolds);
  EXPECT_EQ(judge(own + "at_most: 0.4, holds_in: some", lossy(0)).verdict, Verdict::kDoesNotHold);
  const std::string timed =
      "left: {codec: zfp}, each: [dataset, block_bits], metric: encode_seconds, at_most: 1, "
      "holds_in: ";
  const Fill some_slow = [](const Cell& cell, Row& row) {
    const bool slow = cell.codec == "zfp" && cell.parameters.values().at("block_bits") == "32";
    times(slow ? std::vector<double>{2, 2, 2} : std::vector<double>{0.5, 0.9, 1.1}, {})(cell, row);
  };
  EXPECT_EQ(judge(timed + "all", some_slow).verdict, Verdict::kDoesNotHold);
  EXPECT_EQ(judge(timed + "most", some_slow).verdict, Verdict::kUndecided);
  EXPECT_EQ(judge(timed + "some", some_slow).verdict, Verdict::kUndecided);
}

TEST_F(ClaimsTest, AreShownAsATableAndAsLines) {
  const ClaimVerdict verdict = judge(
      kPair +
          "metric: bits_per_voxel, compare: ratio, at_least: 0.25, at_most: 0.5, tolerance: 0.05",
      lossy(0));
  EXPECT_EQ(render(claims_table(config_, verdicts_), TableFormat::kMarkdown),
            "### Claims: T\n\n"
            "| claim | verdict | figures        |\n"
            "|:------|:--------|:---------------|\n"
            "| c     | holds   | holds: 2; 0.25 |\n"
            "\n"
            "- **c**: \"S\" (P). Checked: bits_per_voxel, left / right, at least 0.25, at most "
            "0.5, tolerance 0.05.\n");
  EXPECT_EQ(render(groups_table(verdicts_), TableFormat::kMarkdown),
            "### Each group of these claims\n\n"
            "| claim | group | verdict | figures      |\n"
            "|:------|:------|:--------|:-------------|\n"
            "| c     | a     | holds   | 1 / 4 = 0.25 |\n"
            "| c     | b     | holds   | 1 / 4 = 0.25 |\n");
  const auto lines = claims_rows(verdicts_);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(
      lines[1].dump(),
      R"({"claim":"c","says":"S","source":"P","claim_verdict":"holds","group":{"dataset":"b"},"verdict":"holds","reason":"1 / 4 = 0.25",)"
      R"("fitted":false,"cells":["b|8x8x8|zfp|block_bits=64;mode=rate;tolerance_log2=0|1|encode","b|8x8x8|zfp|block_bits=64;mode=rate;tolerance_log2=0|1|decode","b|8x8x8|bc4||1|encode","b|8x8x8|bc4||1|decode"],)"
      R"("metric":"bits_per_voxel","compare":"ratio","at_least":0.25,"at_most":0.5,"tolerance":0.05,)"
      R"("compared":[{"sides":[1.0,4.0],"value":0.25,"interval":[0.25,0.25]}]})");
}

TEST_F(ClaimsTest, MistakesHaveTheirPlace) {
  const std::string place = "c.yaml:" + std::to_string(kClaimLine) + ":";
  const std::string ok = "metric: bits_per_voxel, left: {codec: bc4}, each: [dataset], ";
  EXPECT_EQ(error(ok + "at_most: 1"), "no error");
  const auto expect_error = [&](const std::string& keys, const std::string& text) {
    EXPECT_THAT(error(keys), testing::AllOf(testing::StartsWith(place), HasSubstr(text))) << keys;
  };
  expect_error(ok, "expected the key at_least or at_most, found none");
  expect_error(ok + "atmost: 1", "expected one of the keys name, says");
  expect_error(ok + "at_most: 1, at_least: 2", "expected at_least of at most at_most");
  expect_error(ok + "at_most: 1, compare: ratio", "expected the key compare beside right");
  expect_error(ok + "at_most: 1, value: 3", "found them without it");
  expect_error(ok + "at_most: 1, value: 3, right: {codec: zfp}, compare: ratio", "found several");
  expect_error(ok + "at_most: 1, value: 3, compare: quotient",
               "expected difference or ratio, found 'quotient'");
  expect_error(ok + "at_most: 1, tolerance: -1", "expected a number in 0..");
  expect_error(ok + "at_most: 1, holds_in: few", "expected all, most or some, found 'few'");
  expect_error(ok + "at_most: 1, published: {file: none.yaml, table: t}, compare: ratio",
               "expected a file at");
  expect_error(ok + "at_most: 1, published: {file: none, table: t}, compare: ratio",
               "results/published/none.yaml or ");
  expect_error(ok + "at_most: 1, published: {file: p.yaml, table: t}, compare: ratio",
               "expected a metric that publications state");
  expect_error("metric: bits_per_voxl, left: {codec: bc4}, each: [dataset], at_most: 1",
               "did you mean 'bits_per_voxel'?");
  expect_error("metric: status, left: {codec: bc4}, each: [dataset], at_most: 1",
               "expected a metric that is a number, found 'status'");
  expect_error("metric: bits_per_voxel, left: {codek: bc4}, each: [dataset], at_most: 1",
               "did you mean 'codec'?");
  expect_error("metric: bits_per_voxel, left: {codec: bc4}, each: [datasets], at_most: 1",
               "did you mean 'dataset'?");
  expect_error("metric: bits_per_voxel, left: {codec: bc5}, each: [dataset], at_most: 1",
               "expected cells of the stages encode");
  expect_error("metric: warm_ms, left: {codec: bc4}, each: [dataset], at_most: 1",
               "expected cells of the stage render that match");
  expect_error("metric: bits_per_voxel, left: {codec: bc4}, at_most: 1",
               "expected cells that agree in codec, parameters and threads, found 2");
  expect_error(
      "metric: bits_per_voxel, left: {codec: bc4}, right: {codec: zfp, block_bits: 33}, each: "
      "[dataset], compare: ratio, at_most: 1",
      "expected cells that match in the group a, found none");
  expect_error("metric: bits_per_voxel, at_most: 1", "expected the key left or order, found none");
  expect_error("metric: bits_per_voxel, right: {codec: bc4}, at_most: 1",
               "expected the key left beside right");
  expect_error("metric: warm_ms, compare: ratio, order: [{cache: none}]",
               "expected a list of two sides or more");
  expect_error(
      "metric: warm_ms, compare: ratio, at_most: 1, order: [{cache: none}, {cache: voxel}]",
      "expected order without at_least");
  expect_error("metric: warm_ms, order: [{cache: none}, {cache: voxel}]",
               "expected the key compare beside");
  expect_error(ok + "compare: ratio, order: [{codec: bc4}, {codec: zfp}]",
               "expected order or left and right");
  const std::string curves =
      "left: {codec: tvq}, right: {codec: zfp}, each: [dataset], over: bits_per_voxel, at_least: "
      "1, ";
  EXPECT_EQ(error(curves + "metric: volume_psnr_db, compare: difference"), "no error");
  expect_error(curves + "metric: volume_psnr_db, compare: ratio",
               "compare: difference beside over");
  expect_error(curves + "metric: largest_error, compare: difference",
               "expected a metric in dB beside over");
}

/// A volume that was made to meet a published figure proves nothing by meeting it.
TEST_F(ClaimsTest, FittedGroupsAreShownAndNotCounted) {
  const auto bits = [](const Cell& cell, Row& row) {
    row["size"]["bits_per_voxel"] = cell.dataset->name == "a" ? 1 : 9;
  };
  const std::string claim = "metric: bits_per_voxel, left: {codec: bc4}, each: [dataset], ";
  EXPECT_EQ(judge(claim + "at_most: 5", bits).verdict, Verdict::kDoesNotHold);
  const ClaimVerdict fitted = judge(claim + "at_most: 5, fitted: {dataset: b}", bits);
  EXPECT_EQ(fitted.verdict, Verdict::kHolds);
  EXPECT_EQ(fitted.count(Verdict::kDoesNotHold), 0u);
  EXPECT_TRUE(fitted.groups[1].fitted);
  EXPECT_EQ(fitted.groups[1].verdict, Verdict::kDoesNotHold);
  const std::string text = render(groups_table({fitted}), TableFormat::kMarkdown);
  EXPECT_THAT(text, HasSubstr("does not hold, fitted"));
  EXPECT_EQ(judge(claim + "at_most: 5, fitted: {codec: bc4}", bits).verdict, Verdict::kUnchecked);
}

TEST_F(ClaimsTest, WhatCannotBeTestedSaysWhy) {
  const ClaimVerdict verdict = judge("not_testable: no such data", [](const Cell&, Row&) {});
  EXPECT_EQ(verdict.verdict, Verdict::kUnchecked);
  EXPECT_EQ(verdict.groups.front().reason, "no such data");
  EXPECT_THAT(render(claims_table(config_, verdicts_), TableFormat::kMarkdown),
              HasSubstr("| not testable here | no such data |"));
  EXPECT_THAT(error("not_testable: no such data, metric: rate"),
              HasSubstr("expected not_testable alone"));
  EXPECT_THAT(error("left: {codec: bc4}, at_most: 1"), HasSubstr("expected the key metric"));
}

TEST_F(ClaimsTest, GroupsNameTheRowsOfTheirFigures) {
  const auto bits = [](const Cell& cell, Row& row) {
    if (cell.stage->id == "encode") row["size"]["bits_per_voxel"] = 1;
  };
  const ClaimVerdict verdict =
      judge("metric: bits_per_voxel, left: {codec: bc4}, where: {dataset: a}, at_most: 5", bits);
  ASSERT_EQ(verdict.groups.front().cells.size(), 1u);
  EXPECT_THAT(verdict.groups.front().cells.front(), testing::EndsWith("|encode"));
}

}  // namespace
}  // namespace cvr::experiments
