// compare, ab, aa, baseline, history: as a user would type them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kTrackedConfig = R"(title: T
rounds: 12
max_rounds: 12
timeout_s: 30
matrix:
  - datasets: [{generator: cells, extent: [96, 80, 64], name: blob}]
    codecs: [csgvr]
    stages: [encode, decode]
)";

class Tracking : public testing::Test {
 protected:
  void SetUp() override { program_.write("configs/c.yaml", kTrackedConfig); }
  void edit(const std::string& name, const std::string& what, const std::string& with) const {
    std::string text = program_.read(name);
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    program_.write(name, text.replace(at, what.size(), with));
  }
  Program program_;
};

TEST_F(Tracking, ABuildThatDecodesHalfAsFastIsFound) {
  program_.write("slow", "#!/bin/sh\nCVRBENCH_TEST_FAULT='slower=2 * decode' exec " CVRBENCH_FAULTY
                         " \"$@\"\n");
  std::filesystem::permissions(program_ / "slow", std::filesystem::perms::owner_all);
  const Outcome outcome =
      program_.run("ab " CVRBENCH_PROGRAM " slow configs/c.yaml --out o --explain");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("**slower** decode"), HasSubstr("**same** size.bytes"),
                                 HasSubstr("No noise floor")));
  EXPECT_THAT(outcome.out, Not(HasSubstr("**differs**")));
  // The rows of both stand apart, and sample pairs with sample.
  const json a = json::parse(
      program_.read("o/a/rows.jsonl").substr(0, program_.read("o/a/rows.jsonl").find('\n')));
  const json b = json::parse(
      program_.read("o/b/rows.jsonl").substr(0, program_.read("o/b/rows.jsonl").find('\n')));
  EXPECT_EQ(a["cell"], b["cell"]);
  EXPECT_EQ(a["time"]["seconds"]["samples"].size(), b["time"]["seconds"]["samples"].size());
  EXPECT_EQ(program_.run("ab " CVRBENCH_PROGRAM " slow configs/c.yaml --out o2 --fail-on exact")
                .exit_code,
            0);
  const Outcome missing = program_.run("ab nothing slow configs/c.yaml");
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.err, HasSubstr("nothing: expected a program cvrbench, found no file"));
}

TEST_F(Tracking, AChangedFigureIsFoundAndNamed) {
  ASSERT_EQ(program_.run("run configs/c.yaml --out base").exit_code, 0);
  std::filesystem::copy(program_ / "base", program_ / "new",
                        std::filesystem::copy_options::recursive);
  EXPECT_EQ(program_.run("compare base new").exit_code, 0);
  edit("new/rows.jsonl", "\"size\":{\"bytes\":", "\"size\":{\"bytes\":1");
  const Outcome changed = program_.run("compare base new --fail-on exact");
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_THAT(changed.out, HasSubstr("**differs** size."));
  EXPECT_EQ(program_.run("compare base new --fail-on never").exit_code, 0);
  const Outcome lines = program_.run("compare base new --fail-on never --format jsonl");
  const json first = json::parse(lines.out.substr(0, lines.out.find('\n')));
  EXPECT_EQ(first["codec"], "csgvr");
  EXPECT_EQ(program_.run("compare base nowhere").exit_code, 2);
}

TEST_F(Tracking, FloorsAreMeasuredStoredAndUsed) {
  const Outcome outcome = program_.run("aa configs/c.yaml --out o");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("| interleaved | decode |"), HasSubstr("| apart | encode |"),
                    HasSubstr("are called faster or slower")));
  const json stored = json::parse(program_.read("share/cvrbench/noise.json"));
  ASSERT_EQ(stored.size(), 1u);
  EXPECT_GT(stored.begin().value()["apart"]["decode"]["floor"].get<double>(), 0);
  EXPECT_THAT(program_.run("compare o/0/a o/1/a --fail-on never").out,
              Not(HasSubstr("No noise floor")));
}

TEST_F(Tracking, TheBaselineNamesCodecVolumeAndSection) {
  const Outcome before = program_.run("baseline check configs/c.yaml");
  EXPECT_EQ(before.exit_code, 2);
  EXPECT_THAT(before.err, HasSubstr("expected a baseline, found no file"));
  ASSERT_EQ(program_.run("baseline update configs/c.yaml").exit_code, 0);
  EXPECT_EQ(program_.run("baseline check configs/c.yaml").exit_code, 0);
  const json stored = json::parse(program_.read("results/baseline/c.json"));
  const auto figures = stored["cells"].begin().value();
  ASSERT_TRUE(figures.contains("size.checksums.index")) << figures.dump();
  // One byte of the start table: the file's size stays, the section's checksum does not.
  edit("results/baseline/c.json", figures["size.checksums.index"].get<std::string>(),
       "0123456789abcdef");
  const Outcome changed = program_.run("baseline check configs/c.yaml");
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_THAT(changed.out, AllOf(HasSubstr("blob|96x80x64|csgvr"),
                                 HasSubstr("size.checksums.index: \"0123456789abcdef\" ->"),
                                 HasSubstr("1 differ")));
}

TEST_F(Tracking, RowsAreExportedForOtherTools) {
  ASSERT_EQ(program_.run("run configs/c.yaml --out o").exit_code, 0);
  const json file = json::parse(program_.run("export o --format google-benchmark").out);
  ASSERT_TRUE(file.contains("context"));
  std::size_t iterations = 0, medians = 0;
  for (const json& one : file["benchmarks"]) {
    EXPECT_EQ(one["time_unit"], "ns");
    EXPECT_GT(one["real_time"].get<double>(), 0) << one.dump();
    if (one["run_name"] != "blob/96x80x64/csgvr/brick=32/1/decode") continue;
    iterations += one["run_type"] == "iteration";
    medians += one.value("aggregate_name", "") == "median";
    if (one["run_type"] == "iteration") {
      EXPECT_GT(one["bytes"].get<double>(), 0);
    }
  }
  EXPECT_EQ(iterations, 12u);
  EXPECT_EQ(medians, 1u);
  const std::string csv = program_.run("export o --format csv").out;
  EXPECT_THAT(csv.substr(0, csv.find("\r\n")),
              AllOf(HasSubstr("cell,key,status"), HasSubstr("size.breakdown.index"),
                    HasSubstr("time.seconds.median")));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 4);
}

TEST_F(Tracking, HistoryNamesTheCommitOfAStep) {
  ASSERT_EQ(program_.run("run configs/c.yaml --out o --only stage=decode").exit_code, 0);
  std::string row = program_.read("o/rows.jsonl");
  row = row.substr(row.find("\"codec\":{\"id\":\"csgvr\"") == std::string::npos
                       ? 0
                       : row.rfind('\n', row.find("\"codec\":{\"id\":\"csgvr\"")) + 1);
  json measured = json::parse(row.substr(0, row.find('\n')));
  for (int day = 1; day <= 12; ++day) {
    measured["provenance"]["time"] =
        "2026-01-" + std::string(day < 10 ? "0" : "") + std::to_string(day) + "T00:00:00Z";
    measured["provenance"]["revision"] = "commit" + std::to_string(day);
    std::vector<double> samples;
    for (int i = 0; i < 9; ++i)
      samples.push_back((day < 8 ? 0.01 : 0.013) * (1 + 0.004 * ((day * 7 + i * 3) % 5)));
    measured["time"]["seconds"]["samples"] = samples;
    if (day == 10) measured["size"]["bytes"] = measured["size"]["bytes"].get<std::uint64_t>() + 100;
    program_.write("day/rows.jsonl", measured.dump() + "\n");
    ASSERT_EQ(program_.run("history add day --store h").exit_code, 0);
  }
  // Recording a run twice changes nothing.
  EXPECT_THAT(program_.run("history add day --store h").out, HasSubstr("0 figures of 0 cells"));
  const Outcome steps = program_.run("history steps --store h");
  EXPECT_EQ(steps.exit_code, 1);
  EXPECT_THAT(steps.out, AllOf(HasSubstr("commit8 (after commit7)"),
                               HasSubstr("commit10 (after commit9)"), HasSubstr("WORSE")));
  EXPECT_EQ(program_.run("history steps --store h --since 2026-01-11").exit_code, 0);
  EXPECT_EQ(program_.run("history steps --store nowhere").exit_code, 1) << "nothing to judge";
}

}  // namespace
}  // namespace cvr::cli_tests
