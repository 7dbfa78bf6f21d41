// Commands that measure or judge where there is nothing to measure or to judge: never 0, and a
// sentence that says why.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kMissing =
    "rounds: 1\nmatrix:\n  - {datasets: [bonsai], codecs: [raw], stages: [encode]}\n";
constexpr const char* kSmall = R"(title: T
rounds: 1
matrix:
  - datasets: [{generator: cells, extent: [12, 10, 8], name: blob}]
    codecs: [raw]
    stages: [encode]
tables:
  - {name: t, title: Sizes, rows: [dataset, codec], columns: [rate, status]}
claims:
  - {name: raw-is-raw, says: "raw stores the voxels", source: P, metric: rate, left: {codec: raw}, at_most: 1000}
)";

class Judging : public testing::Test {
 protected:
  void expect_nothing(const std::string& arguments, int exit_code, const std::string& sentence,
                      const std::string& fault = "none") const {
    const Outcome outcome = program_.run_with_fault(fault, arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << "\n" << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(sentence)) << arguments;
  }
  Program program_;
};

TEST_F(Judging, ARunWithoutDataIsTheEnvironmentsFault) {
  program_.write("configs/c.yaml", kMissing);
  expect_nothing("run configs/c.yaml --out o", 3,
                 "nothing was measured: no cell is ok (2 data-missing)");
  EXPECT_THAT(program_.run("run configs/c.yaml --out o2").err, HasSubstr("CVRBENCH_DATA"));
  expect_nothing("run configs/c.yaml --out o --resume", 3, "nothing was measured");
  expect_nothing("ab " CVRBENCH_PROGRAM " " CVRBENCH_PROGRAM " configs/c.yaml --out ab", 3,
                 "nothing was measured");
  expect_nothing("aa configs/c.yaml --out aa", 3, "nothing was measured");
  EXPECT_EQ(program_.read("share/cvrbench/noise.json"), "") << "floors of nothing";
  expect_nothing("baseline update configs/c.yaml", 3, "nothing was measured");
  EXPECT_EQ(program_.read("results/baseline/c.json"), "") << "a baseline of nothing";
  expect_nothing("baseline check configs/c.yaml", 3, "nothing was measured");
  expect_nothing("history add o --store h", 1, "nothing was recorded");
  expect_nothing("export o --format csv", 1, "no row of these folders is ok");
  expect_nothing("export o --format google-benchmark", 1, "no row of these folders is ok");
  expect_nothing("compare o o", 1, "nothing was compared: no cell is ok in both");
}

TEST_F(Judging, ARunWhoseCellsAllFailHasFailed) {
  program_.write("c.yaml", kSmall);
  expect_nothing("run c.yaml --out o", 1, "nothing was measured: no cell is ok (2 failed)",
                 "crash");
  program_.write("h.yaml", std::string(kSmall) + "timeout_s: 0.3\n");
  expect_nothing("run h.yaml --out h", 1, "nothing was measured: no cell is ok (2 timeout)",
                 "hang");
  program_.write("u.yaml",
                 "rounds: 1\nmatrix:\n  - {datasets: [{generator: cells, extent: [8, 8, 8], name: "
                 "b}], codecs: [bc4], stages: [random-access]}\n");
  expect_nothing("run u.yaml --out u", 1, "nothing was measured: no cell is ok (1 unsupported)");
  expect_nothing("compare o o", 1, "nothing was compared");
  expect_nothing("claims c.yaml --results o", 1, "none of 1 claims can be checked");
  expect_nothing("table c.yaml --results o", 1, "no cell of c.yaml is ok there");
}

TEST_F(Judging, FoldersWithoutRowsOrWithoutACommonCell) {
  program_.write("c.yaml", kSmall);
  program_.write("a/rows.jsonl", "");
  program_.write("b/rows.jsonl", "");
  std::filesystem::create_directories(program_ / "empty");
  expect_nothing("compare a b", 1, "nothing was compared: no cell is ok in both, of 0 and 0 rows");
  expect_nothing("compare a b --fail-on never", 1, "nothing was compared");
  expect_nothing("compare empty empty", 2,
                 "empty/rows.jsonl: expected the rows of a run, found no such file");
  expect_nothing("claims c.yaml --results a", 1, "none of 1 claims can be checked");
  expect_nothing("table c.yaml --results a", 1, "no cell of c.yaml is ok there");
  expect_nothing("export a --format csv", 1, "no row of these folders is ok");
  expect_nothing("history add a --store h", 1, "nothing was recorded");
  expect_nothing("history steps --store h", 1, "no figures of the machine");
  expect_nothing("history steps --store nowhere --all-machines", 1, "no figures of any machine");
  ASSERT_EQ(program_.run("run c.yaml --out o").exit_code, 0);
  program_.write("d.yaml",
                 "rounds: 1\nmatrix:\n  - {datasets: [{generator: cells, extent: [8, 8, 8], name: "
                 "other}], codecs: [raw], stages: [encode]}\n");
  ASSERT_EQ(program_.run("run d.yaml --out p").exit_code, 0);
  expect_nothing("compare o p", 1, "nothing was compared: no cell is ok in both, of 2 and 2 rows");
  EXPECT_EQ(program_.run("compare o o").exit_code, 0);
  EXPECT_EQ(program_.run("claims c.yaml --results o").exit_code, 0);
  EXPECT_EQ(program_.run("table c.yaml --results o").exit_code, 0);
  EXPECT_EQ(program_.run("history add o --store h").exit_code, 0);
  EXPECT_EQ(program_.run("history add o --store h").exit_code, 0) << "known already";
  EXPECT_EQ(program_.run("history steps --store h").exit_code, 0);
  EXPECT_EQ(program_.run("export o --format google-benchmark").exit_code, 0);
}

TEST_F(Judging, AResumeSaysWhereRowsHaveMoreRoundsThanAreAllowed) {
  program_.write("c.yaml", kSmall);
  ASSERT_EQ(program_.run("run c.yaml --out o --set rounds=4 --set max_rounds=4").exit_code, 0);
  const Outcome resumed = program_.run("run c.yaml --out o --resume --set max_rounds=2");
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_THAT(
      resumed.err,
      AllOf(HasSubstr(
                "2 cells that are done have more rounds than max_rounds allows (2) and are kept"),
            HasSubstr("--force")));
  EXPECT_THAT(program_.run("run c.yaml --out o --resume --set rounds=4 --set max_rounds=4").err,
              Not(HasSubstr("more rounds")));
}

TEST_F(Judging, HostileRowsAreRefusedOrEscaped) {
  program_.write("c.yaml", kSmall);
  ASSERT_EQ(program_.run("run c.yaml --out o").exit_code, 0);
  const std::string rows = program_.read("o/rows.jsonl");
  json row = json::parse(rows.substr(0, rows.find('\n')));
  row["codec"]["id"] = "a|b`<img src=x>\n| \\input{x}";
  json other = row;
  other["status"] = "failed";
  other["reason"] = "x\n\n# title\x1b[2J [y](javascript:z)";
  program_.write("p/rows.jsonl", row.dump() + "\n");
  program_.write("q/rows.jsonl", other.dump() + "\n");
  const Outcome compared = program_.run("compare p q --explain");
  EXPECT_EQ(compared.exit_code, 1) << compared.err;
  EXPECT_THAT(compared.out, AllOf(HasSubstr("a\\|b\\`\\<img"), Not(HasSubstr("\n# title")),
                                  Not(HasSubstr("\x1b")), HasSubstr("\\n\\n# title\\x1b")));
  for (const auto& [field, value] :
       std::vector<std::pair<const char*, json>>{{"key", 5},
                                                 {"provenance", json::array()},
                                                 {"codec", "x"},
                                                 {"time", nullptr},
                                                 {"status", 3}}) {
    json bad = json::parse(rows.substr(0, rows.find('\n')));
    bad[field] = value;
    program_.write("bad/rows.jsonl", bad.dump() + "\n");
    for (const char* command :
         {"compare bad bad", "compare o bad", "export bad --format google-benchmark",
          "export bad --format csv", "history add bad --store s", "table c.yaml --results bad",
          "claims c.yaml --results bad"}) {
      const Outcome outcome = program_.run(command);
      EXPECT_EQ(outcome.exit_code, 2) << command << " " << field << " " << outcome.err;
    }
  }
  json away = json::parse(rows.substr(0, rows.find('\n')));
  away["provenance"]["machine"] = "../../escaped";
  program_.write("away/rows.jsonl", away.dump() + "\n");
  const Outcome refused = program_.run("history add away --store h/s");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("expected a machine of letters, digits"));
}

TEST_F(Judging, DeepOrDoubledJsonOfBaselinesFloorsAndHistoryIsRefused) {
  program_.write("configs/c.yaml", kSmall);
  ASSERT_EQ(program_.run("run configs/c.yaml --out o").exit_code, 0);
  const json row = json::parse(
      program_.read("o/rows.jsonl").substr(0, program_.read("o/rows.jsonl").find('\n')));
  const std::string machine = row["provenance"]["machine"].get<std::string>();
  for (const std::string& text : {std::string(300000, '['), std::string("{\"a\": 1, \"a\": 2}"),
                                  std::string("{"), std::string("")}) {
    program_.write("results/baseline/c.json", text);
    program_.write("noise.json", text);
    program_.write("h/" + machine + ".jsonl", text + "\n");
    expect_nothing("baseline check configs/c.yaml", 2, "c.json");
    expect_nothing("compare o o --noise noise.json", 2, "noise.json");
    expect_nothing("history steps --store h", 2, machine + ".jsonl:1");
  }
}

}  // namespace
}  // namespace cvr::cli_tests
