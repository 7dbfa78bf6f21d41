// run, plan and table: rows, tables, resuming, and workers that crash, hang, run out of memory or
// decode wrongly.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kRunConfig = R"(title: T
rounds: 3
max_rounds: 3
timeout_s: 20
memory_limit_gib: 1
lods: all
matrix:
  - datasets: [{generator: cells, extent: [40, 24, 33], name: blob}]
    codecs: [raw, zstd, {id: csgvr-sb, parameters: {brick: [16, 32]}}]
    stages: [encode, decode, random-access]
    threads: [1]
tables:
  - {name: t, title: Sizes, rows: [dataset, codec, brick], columns: [rate, encode_seconds, access_uniform_ns, exact, status]}
)";

class Run : public testing::Test {
 protected:
  void SetUp() override { program_.write("c.yaml", kRunConfig); }
  std::vector<json> rows(const std::string& out = "o") const {
    std::istringstream in(program_.read(out + "/rows.jsonl"));
    std::vector<json> rows;
    for (std::string line; std::getline(in, line);) rows.push_back(json::parse(line));
    return rows;
  }
  std::map<std::string, json> by_key(const std::string& out = "o") const {
    std::map<std::string, json> found;
    for (const json& row : rows(out))
      found[row["codec"]["id"].get<std::string>() + " " + row["stage"].get<std::string>()] = row;
    return found;
  }
  Program program_;
};

TEST_F(Run, MeasuresChecksAndPrintsTables) {
  const Outcome outcome = program_.run("run c.yaml --out o");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(rows().size(), 2u + 4 * 3);
  const auto found = by_key();
  const json& encode = found.at("csgvr-sb encode");
  EXPECT_EQ(encode["status"], "ok");
  EXPECT_EQ(encode["verification"]["voxels_compared"], 40 * 24 * 33);
  EXPECT_EQ(encode["verification"]["mismatches"], 0);
  EXPECT_EQ(encode["time"]["seconds"]["samples"].size(), 3u);
  EXPECT_GT(encode["memory"]["peak_bytes"].get<double>(), 1e5);
  EXPECT_EQ(encode["dataset"]["label"], "generated");
  EXPECT_EQ(encode["provenance"]["compiler"].get<std::string>().empty(), false);
  std::uint64_t sum = 0;
  for (const auto& [name, bytes] : encode["size"]["breakdown"].items())
    sum += bytes.get<std::uint64_t>();
  EXPECT_EQ(encode["size"]["bytes"], sum);
  const json& access = found.at("csgvr-sb random-access");
  EXPECT_EQ(access["status"], "ok") << access["reason"];
  EXPECT_EQ(access["access"].size() % 3, 0u);
  EXPECT_GT(access["access"].size(), 3u) << "coarser levels of detail are missing";
  for (const json& series : access["access"]) EXPECT_GE(series["count"].get<int>(), 100000);
  EXPECT_EQ(found.at("zstd random-access")["status"], "unsupported");
  EXPECT_THAT(outcome.out, HasSubstr("| blob    | memcpy "));
  EXPECT_THAT(outcome.out, HasSubstr("0 of 31680 differ"));
  EXPECT_THAT(program_.read("o/tables/t.md"), HasSubstr("### Sizes"));
  EXPECT_THAT(program_.read("o/tables/t.csv"),
              testing::StartsWith("dataset,codec,brick,file rate %"));
  EXPECT_THAT(program_.read("o/tables/t.tex"), HasSubstr("\\begin{tabular}"));
  EXPECT_EQ(program_.run("table c.yaml --results o --format csv").out,
            program_.read("o/tables/t.csv"));
  const std::string table = program_.read("o/tables/t.json");
  EXPECT_EQ(program_.run("table c.yaml --results o --format json").out, table);
  const json t = json::parse(table);
  EXPECT_EQ(t["name"], "t");
  EXPECT_EQ(t["columns"].size(), 8u);
  EXPECT_EQ(t["lines"].size(), 5u);
  EXPECT_GT(t["lines"][1]["cells"][3]["number"].get<double>(), 99);
  EXPECT_EQ(t["lines"][1]["cells"][4]["interval"].size(), 2u);
  EXPECT_EQ(program_.read("o/codecs.json"), program_.run("list codecs --json").out);
}

TEST_F(Run, RoundsCanBeSpreadOverProcesses) {
  const std::string command =
      "run c.yaml --out o --only codec=csgvr-sb --only codec=zstd "
      "--only stage=encode --only stage=decode";
  ASSERT_EQ(program_.run(command + " --set rounds_per_process=2").exit_code, 0);
  for (const json& row : rows()) {
    EXPECT_EQ(row["status"], "ok") << row;
    EXPECT_EQ(row["time"]["seconds"]["samples"].size(), 3u);
    EXPECT_EQ(row["processes"], 2);
    EXPECT_GT(row["memory"]["peak_bytes"].get<double>(), 1e5);
  }
  ASSERT_EQ(program_.run("run c.yaml --out p --only codec=zstd --only stage=encode").exit_code, 0);
  EXPECT_FALSE(rows("p").front().contains("processes"));
  EXPECT_EQ(rows("p").front()["cell"], by_key()["zstd encode"]["cell"]);
}

constexpr const char* kClaims = R"(claims:
  - name: smaller
    says: "zstd is smaller than the voxels"
    source: "Paper, section 1"
    metric: rate
    left: {codec: zstd}
    right: {codec: raw}
    compare: ratio
    at_most: 1
  - {name: large-bricks, says: "larger bricks are smaller by half", source: P, metric: rate, left: {brick: 32}, right: {brick: 16}, compare: ratio, at_most: 0.5}
  - {name: fast, says: "zstd decodes in a day", source: P, metric: decode_seconds, left: {codec: zstd}, at_most: 86400}
)";

TEST_F(Run, ClaimsAreJudgedUnderTheTablesAndFromStoredRows) {
  program_.write("p.yaml", std::string(kRunConfig) + kClaims);
  const Outcome outcome = program_.run("run p.yaml --out o --only stage=encode");
  EXPECT_EQ(outcome.exit_code, 0) << "a claim that does not hold is no failure: " << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("### Claims: T"));
  EXPECT_THAT(outcome.out, testing::ContainsRegex(
                               "\\| smaller +\\| holds +\\| [0-9.]+ / 100[.0-9]* = 0[.0-9]+ "));
  EXPECT_THAT(outcome.out, testing::ContainsRegex("\\| large-bricks +\\| does not hold +\\| "));
  EXPECT_THAT(outcome.out, testing::ContainsRegex(
                               "\\| fast +\\| not testable here \\| zstd .*has no decode_seconds"));
  EXPECT_THAT(outcome.out,
              HasSubstr("- **smaller**: \"zstd is smaller than the voxels\" (Paper, section 1)."));
  std::istringstream lines(program_.read("o/claims/p.jsonl"));
  std::vector<std::string> verdicts;
  for (std::string line; std::getline(lines, line);)
    verdicts.push_back(json::parse(line)["verdict"]);
  EXPECT_THAT(verdicts, testing::ElementsAre("holds", "does not hold", "not testable here"));
  EXPECT_EQ(program_.run("claims p.yaml --results o").out, program_.read("o/claims/p.md"));
  EXPECT_EQ(program_.run("claims p.yaml --results o --format jsonl").out,
            program_.read("o/claims/p.jsonl"));
  ASSERT_EQ(program_.run("run p.yaml --out o --resume").exit_code, 0);
  EXPECT_THAT(program_.read("o/claims/p.md"), testing::ContainsRegex("\\| fast +\\| holds "));
  EXPECT_EQ(program_.run("claims c.yaml --results o").exit_code, 2) << "without claims";
  EXPECT_EQ(program_.run("claims p.yaml --results none").exit_code, 2) << "without rows";
  program_.write("bad.yaml", std::string(kRunConfig) +
                                 "claims:\n  - {name: a, says: b, source: c, metric: rate, left: "
                                 "{codec: lzma}, at_most: 1}\n");
  const Outcome bad = program_.run("plan bad.yaml");
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_THAT(bad.err, HasSubstr("bad.yaml:15:55: expected cells of the stages encode, decode or "
                                 "random-access that match, found none"));
}

TEST_F(Run, ExistingRowsAreKeptResumedOrMeasuredAgainAsAsked) {
  ASSERT_EQ(program_.run("run c.yaml --out o --only codec=raw").exit_code, 0);
  ASSERT_EQ(rows().size(), 3u);
  const Outcome refused = program_.run("run c.yaml --out o");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--resume"));
  const std::string before = program_.read("o/rows.jsonl");
  const Outcome plan = program_.run("plan c.yaml --out o --only codec=raw");
  EXPECT_THAT(plan.out, HasSubstr("0 to run, 3 done"));
  ASSERT_EQ(program_.run("run c.yaml --out o --resume --only codec=raw").exit_code, 0);
  EXPECT_EQ(program_.read("o/rows.jsonl"), before);
  ASSERT_EQ(
      program_.run("run c.yaml --out o --force --only codec=raw --only stage=encode").exit_code, 0);
  EXPECT_EQ(rows().size(), 4u);
}

TEST_F(Run, CrashHangMemoryAndWrongVoxelsBecomeRows) {
  const std::map<std::string, std::pair<std::string, std::string>> expected{
      {"crash", {"failed", "signal 11"}},
      {"hang", {"timeout", "took longer than 0.5 s"}},
      {"oom", {"out-of-memory", "memory"}},
      {"mismatch", {"failed", "1 of 31680 decoded voxels differ"}}};
  for (const auto& [fault, status] : expected) {
    program_.write("f.yaml", kRunConfig);
    const std::string settings = fault == "hang"  ? " --set timeout_s=0.5"
                                 : fault == "oom" ? " --set memory_limit_gib=0.3"
                                                  : "";
    const Outcome outcome = program_.run_with_fault(
        fault + " csgvr-sb decode", "run f.yaml --out " + fault +
                                        " --only stage=decode --only brick=16 --only codec=*sb" +
                                        settings);
    EXPECT_EQ(outcome.exit_code, 1) << fault << outcome.err;  // the only cell there is
    const auto found = by_key(fault);
    ASSERT_EQ(found.size(), 1u);
    const json& row = found.at("csgvr-sb decode");
    EXPECT_EQ(row["status"], status.first) << fault;
    EXPECT_THAT(row["reason"].get<std::string>(), HasSubstr(status.second));
    EXPECT_FALSE(row.contains("time") || row.contains("size")) << fault;
    EXPECT_THAT(outcome.out, HasSubstr(status.first));
  }
}

constexpr const char* kLossyConfig = R"(title: T
rounds: 2
max_rounds: 2
timeout_s: 20
memory_limit_gib: 1
matrix:
  - datasets: [{generator: shells, extent: [40, 24, 33], name: walls}]
    codecs: [raw, {id: zfp, parameters: {block_bits: [32, 64, 128, 256]}}, {id: zfp, parameters: {mode: accuracy, tolerance_log2: [2, 3, 4, 5]}}, bc4]
    stages: [encode]
  - datasets: [{generator: shells, extent: [40, 24, 33], name: walls}]
    codecs: [raw, zstd, {id: zfp, parameters: {mode: accuracy, tolerance_log2: 2}}, bc4]
    stages: [decode, random-access]
tables:
  - {name: t, title: T, where: {kind: scalars}, rows: [codec, mode, block_bits], columns: [bits_per_voxel, volume_psnr_db, edge_psnr_db, pareto, status]}
  - {name: bd, title: BD, rows: [dataset, codec, mode], bd_psnr: zfp rate}
)";

TEST_F(Run, LossyCellsCarryTheirErrorsAndAreOkWhileTheyKeepThem) {
  program_.write("l.yaml", kLossyConfig);
  const Outcome outcome = program_.run("run l.yaml --out o");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const json& row : rows()) {
    const std::string id = row["codec"]["id"], stage = row["stage"];
    SCOPED_TRACE(row["key"].get<std::string>());
    if (id == "zstd" && stage == "random-access") continue;  // no access to single voxels
    ASSERT_EQ(row["status"], "ok") << row["reason"];
    if (stage == "random-access") {
      EXPECT_EQ(row["access"].size(), 2u);  // uniform and clustered; scalars have no labels
      EXPECT_GT(row["verification"]["points_compared"].get<int>(), 0);
    }
    const bool lossy = id == "zfp" || id == "bc4";
    ASSERT_EQ(row.contains("error"), lossy);
    if (!lossy) continue;
    EXPECT_GT(row["error"]["psnr_db"].get<double>(), 20);
    EXPECT_GT(row["error"]["edge_voxels"].get<int>(), 0);
    EXPECT_NEAR(row["error"]["recorded"]["mean_squared_error"].get<double>(),
                row["error"]["mean_squared_error"].get<double>(), 1e-9);
  }
  EXPECT_THAT(outcome.out, HasSubstr("     8.0485 |   exact |        exact |"));
  EXPECT_THAT(outcome.out, HasSubstr("| walls   | zfp   | rate     |      4 |"));
}

TEST_F(Run, ALossyCellWhoseErrorIsAnotherThanItRecordsHasFailed) {
  program_.write("l.yaml", kLossyConfig);
  program_.run_with_fault(
      "mismatch zfp",
      "run l.yaml --out o --only codec=zfp --only mode=accuracy --only tolerance_log2=2 --only "
      "stage=decode");
  const auto found = by_key();
  EXPECT_EQ(found.at("zfp decode")["status"], "failed");
  EXPECT_THAT(found.at("zfp decode")["reason"].get<std::string>(),
              HasSubstr("mean squared error: the file records"));
  EXPECT_FALSE(found.at("zfp decode").contains("time"));
}

TEST_F(Run, LabelStatisticsAreHeldToAPlainCountOfTheOriginal) {
  program_.write("s.yaml", R"(rounds: 2
max_rounds: 2
timeout_s: 60
matrix:
  - datasets: [{generator: cells, extent: [70, 40, 33], name: blob}]
    codecs: [raw, zstd, csgvr-sb, zfp]
    stages: [label-statistics]
tables:
  - {name: t, title: T, rows: [codec], columns: [label_statistics_ns, bricks_decoded, status]}
)");
  ASSERT_EQ(program_.run("run s.yaml --out o").exit_code, 0);
  const auto found = by_key();
  ASSERT_EQ(found.size(), 4u);
  const std::uint64_t labels = found.at("raw label-statistics")["label_statistics"]["labels"];
  EXPECT_GT(labels, 1u);
  for (const char* codec : {"raw", "zstd", "csgvr-sb"}) {
    const json& row = found.at(std::string(codec) + " label-statistics");
    ASSERT_EQ(row["status"], "ok") << row["reason"];
    EXPECT_EQ(row["verification"]["labels_compared"], labels);
    EXPECT_EQ(row["label_statistics"]["by"],
              codec == std::string("csgvr-sb") ? "bricks" : "volume");
    EXPECT_GT(row["label_statistics"]["ns_per_voxel"].get<double>(), 0);
  }
  EXPECT_EQ(found.at("zfp label-statistics")["status"], "unsupported");
  EXPECT_THAT(program_.read("o/tables/t.csv"), testing::ContainsRegex("csgvr-sb,[0-9.e+]+,11,ok"));
  // One voxel of the encoded volume has another label.
  EXPECT_EQ(program_.run_with_fault("mismatch csgvr-sb", "run s.yaml --out f --only codec=csgvr-sb")
                .exit_code,
            1);
  const auto failed = by_key("f");
  const json& wrong = failed.at("csgvr-sb label-statistics");
  EXPECT_EQ(wrong["status"], "failed");
  EXPECT_THAT(wrong["reason"].get<std::string>(), HasSubstr("expected"));
  EXPECT_FALSE(wrong.contains("time"));
}

TEST_F(Run, OneBrokenCellLeavesTheOthersAlone) {
  program_.write("f.yaml", kRunConfig);
  const Outcome outcome =
      program_.run_with_fault("crash zstd", "run f.yaml --out o --only stage=encode");
  EXPECT_EQ(outcome.exit_code, 1);
  const auto found = by_key();
  EXPECT_EQ(found.at("zstd encode")["status"], "failed");
  for (const char* codec : {"raw encode", "csgvr-sb encode", "memcpy encode"})
    EXPECT_EQ(found.at(codec)["status"], "ok") << codec;
}

TEST_F(Run, AKillInTheMiddleLosesNoFinishedCellAndResumes) {
  // The group of the encoding cells ends; the decoding of zstd then hangs until the kill.
  program_.write("f.yaml", kRunConfig);
  const pid_t child = fork();
  if (child == 0) {
    if (chdir((program_ / "").c_str()) != 0) _exit(126);
    setenv("XDG_CACHE_HOME", (program_ / "cache").c_str(), 1);
    if (freopen("/dev/null", "w", stdout) == nullptr ||
        freopen("/dev/null", "w", stderr) == nullptr)
      _exit(126);
    setenv("CVRBENCH_TEST_FAULT", "hang zstd decode", 1);
    execl(CVRBENCH_FAULTY, "cvrbench", "run", "f.yaml", "--out", "o", nullptr);
    _exit(127);
  }
  const auto count = [&] { return std::ranges::count(program_.read("o/rows.jsonl"), '\n'); };
  // memcpy and four codecs encode; zstd's random access is unsupported and so has its row at once.
  for (int i = 0; i < 600 && count() < 6; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_GE(count(), 6);
  kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const auto before = rows();
  program_.write("o/rows.jsonl", program_.read("o/rows.jsonl") + R"({"cell": "torn)");
  const Outcome resumed = program_.run("run c.yaml --out o --resume");
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_THAT(resumed.out, HasSubstr("done before"));
  const auto after = rows();
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(after[i], before[i]);
  std::map<std::string, int> ok;
  for (const json& row : after) ok[row["cell"].get<std::string>()] += row["status"] == "ok" ? 1 : 0;
  EXPECT_EQ(ok.size(), 14u);
  EXPECT_EQ(std::ranges::count_if(ok, [](const auto& entry) { return entry.second == 1; }),
            13);  // zstd has no random access
}

TEST_F(Run, InterruptedRunsEndTheirWorkersAndCanBeResumed) {
  program_.write("f.yaml", kRunConfig);
  const pid_t child = fork();
  if (child == 0) {
    if (chdir((program_ / "").c_str()) != 0) _exit(126);
    setenv("XDG_CACHE_HOME", (program_ / "cache").c_str(), 1);
    if (freopen("/dev/null", "w", stdout) == nullptr ||
        freopen("/dev/null", "w", stderr) == nullptr)
      _exit(126);
    setenv("CVRBENCH_TEST_FAULT", "hang * encode", 1);
    execl(CVRBENCH_FAULTY, "cvrbench", "run", "f.yaml", "--out", "o", nullptr);
    _exit(127);
  }
  for (int i = 0; i < 200 && !std::filesystem::exists(program_ / "o/scratch"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(child, SIGINT);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
  EXPECT_EQ(program_.run("run c.yaml --out o --resume --only codec=raw").exit_code, 0);
}

TEST_F(Run, MissingDataIsARow) {
  program_.write("c.yaml",
                 "rounds: 1\nmatrix:\n  - {datasets: [bonsai], codecs: [raw], stages: [encode]}\n");
  const Outcome outcome = program_.run("run c.yaml --out o");
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  EXPECT_EQ(by_key().at("raw encode")["status"], "data-missing");
  EXPECT_THAT(by_key().at("raw encode")["reason"].get<std::string>(), HasSubstr("CVRBENCH_DATA"));
}

TEST_F(Run, ConfigurationErrorsHaveTheirPlace) {
  program_.write("bad.yaml", "rounds: 3\nmatrx: []\n");
  const Outcome outcome = program_.run("run bad.yaml --out o");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("bad.yaml:2:1: expected one of the keys"));
  EXPECT_THAT(outcome.err, HasSubstr("did you mean 'matrix'?"));
  EXPECT_EQ(program_.run("run c.yaml --out o --only codec=none").exit_code, 2);
  EXPECT_EQ(program_.run("run c.yaml --out o --only codec").exit_code, 2);
}

}  // namespace
}  // namespace cvr::cli_tests
