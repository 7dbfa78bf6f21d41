// What plan says of memory before anything has run, against what workers then take, for every codec
// and stage at two sizes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using nlohmann::json;

constexpr double kMiB = 1 << 20;
constexpr double kTolerance = 0.25;

/// Cell id -> MiB, of the cells that plan would run.
std::map<std::string, double> planned_mib(const std::string& text) {
  std::map<std::string, double> found;
  const std::regex line(R"(run +([0-9a-f]{16}) .*?, ([0-9]+) MiB)");
  std::istringstream in(text);
  std::smatch match;
  for (std::string next; std::getline(in, next);) {
    if (std::regex_search(next, match, line)) found[match[1]] = std::stod(match[2]);
  }
  return found;
}

std::map<std::string, json> rows_of(const Program& program, const std::string& out) {
  std::istringstream in(program.read(out + "/rows.jsonl"));
  std::map<std::string, json> rows;
  for (std::string line; std::getline(in, line);) {
    json row = json::parse(line);
    rows[row["cell"]] = row;
  }
  return rows;
}

std::string config(const std::string& datasets, const std::string& codecs) {
  return "title: T\nrounds: 2\nmax_rounds: 2\ntimeout_s: 120\nmatrix:\n  - datasets: [" + datasets +
         "]\n    codecs: " + codecs +
         "\n    stages: [encode, decode, random-access]\n    threads: [1]\n";
}

class Memory : public testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer's memory is not the program's";
#endif
  }

  /// Two minutes of work: ctest -L slow.
  void expect_forecast(const std::string& text) {
    if (std::getenv("CVRBENCH_SLOW") == nullptr) GTEST_SKIP() << "takes minutes: ctest -L slow";
    program_.write("c.yaml", text);
    const Outcome plan = program_.run("plan c.yaml --out o");
    ASSERT_EQ(plan.exit_code, 0) << plan.err;
    const auto planned = planned_mib(plan.out);
    ASSERT_EQ(program_.run("run c.yaml --out o").exit_code, 0);
    std::size_t compared = 0;
    for (const auto& [id, row] : rows_of(program_, "o")) {
      if (row["status"] != "ok") continue;
      ASSERT_TRUE(planned.contains(id)) << row["key"];
      const double took = row["memory"]["peak_over_input"].get<double>() / kMiB;
      EXPECT_NEAR(planned.at(id) / took, 1, kTolerance)
          << row["key"] << ": planned " << planned.at(id) << " MiB, took " << took << ", a file of "
          << (row.contains("size") ? row["size"]["bytes"].get<double>() / kMiB : 0);
      ++compared;
    }
    EXPECT_GT(compared, 20u);
  }

  Program program_;
};

TEST_F(Memory, OfLabelsIsForecast) {
  expect_forecast(
      config("{generator: cells, extent: [96, 96, 96], name: small}, {generator: cells, extent: "
             "[120, 120, 120], name: large}",
             "lossless"));
}

TEST_F(Memory, OfScalarsIsForecast) {
  expect_forecast(
      config("{generator: turbulence, parameters: {bits: 8}, extent: [64, 64, 64], name: small}, "
             "{generator: turbulence, parameters: {bits: 32}, extent: [96, 96, 96], name: large}",
             "[zstd, lzma, hdf5-gzip, zfp, astc, bc4, vq, hvq, tvq]"));
}

/// A row of the same cell is the forecast; one of another volume scales it.
TEST_F(Memory, RowsTeachThePlan) {
  program_.write("c.yaml",
                 config("{generator: cells, extent: [64, 64, 64], name: small}", "[zstd]"));
  program_.write("d.yaml",
                 config("{generator: cells, extent: [96, 96, 96], name: large}", "[zstd]"));
  const auto before = planned_mib(program_.run("plan d.yaml --out o").out);
  ASSERT_EQ(program_.run("run c.yaml --out o").exit_code, 0);
  // As if the machine took twice as much.
  std::istringstream in(program_.read("o/rows.jsonl"));
  std::string changed;
  std::map<std::string, double> measured;
  for (std::string line; std::getline(in, line);) {
    json row = json::parse(line);
    if (row["status"] == "ok") {
      row["memory"]["peak_over_input"] = 300 << 20;
      measured[row["cell"]] = 300;
    }
    changed += row.dump() + "\n";
  }
  program_.write("o/rows.jsonl", changed);
  const auto same = planned_mib(program_.run("plan c.yaml --out o --force").out);
  for (const auto& [id, mib] : measured) EXPECT_EQ(same.at(id), mib);
  const auto other = planned_mib(program_.run("plan d.yaml --out o").out);
  ASSERT_FALSE(other.empty());
  for (const auto& [id, mib] : other) EXPECT_GT(mib, 3 * before.at(id));
}

}  // namespace
}  // namespace cvr::cli_tests
