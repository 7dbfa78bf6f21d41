// Runs that are killed, interrupted, stopped, resumed, or meet another run in their folder: no
// finished round or row is lost, torn or doubled, and no worker outlives its run.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <vector>

#include "tests/cli/child.hpp"

namespace cvr::cli_tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using namespace std::chrono_literals;

/// Five rows: memcpy, raw and zstd encode, raw is read at random, zstd cannot be.
constexpr const char* kKilledConfig = R"(title: K
rounds: 5
max_rounds: 5
timeout_s: 60
lods: [0]
matrix:
  - datasets: [{generator: cells, extent: [16, 12, 9], name: blob}]
    codecs: [raw, zstd]
    stages: [encode, random-access]
)";

std::vector<json> whole_lines(const std::string& text) {
  std::vector<json> lines;
  std::size_t at = 0;
  for (std::size_t end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
    lines.push_back(json::parse(text.substr(at, end - at)));
  return lines;
}

std::string without_torn_line(const std::string& text) {
  return text.substr(0, text.rfind('\n') + 1);
}

/// Cell, status and rounds of every row, sorted.
std::vector<std::string> outcomes(const std::string& rows) {
  std::vector<std::string> found;
  for (const json& row : whole_lines(rows)) {
    found.push_back(row["cell"].get<std::string>() + " " + row["status"].get<std::string>() + " " +
                    (row.contains("time") ? row["time"]["rounds"].dump() : "-"));
  }
  std::ranges::sort(found);
  return found;
}

/// Wall seconds of the first series of each round in the journal, by cell.
std::map<std::string, std::vector<double>> rounds_in(const std::string& journal) {
  std::map<std::string, std::vector<double>> rounds;
  for (const json& line : whole_lines(journal)) {
    const std::string cell = line["cell"];
    rounds[cell.substr(0, cell.find(' '))].push_back(line["samples"][0][1].get<double>());
  }
  return rounds;
}

class Kill : public testing::Test {
 protected:
  void SetUp() override { program_.write("c.yaml", kKilledConfig); }
  /// Of a run that hangs in its last cell, with rows and a journal.
  static constexpr const char* kHang = "hang raw random-access";
  bool hangs(const Child& child, const std::string& out = "o") const {
    return wait_until([&] {
      return whole_lines(program_.read(out + "/rows.jsonl")).size() >= 4 && child.processes() >= 2;
    });
  }
  Program program_;
};

/// One folder that is killed and resumed until its run ends or enough kills are done.
class Campaign {
 public:
  Campaign(const Program& program, const std::string& out) : program_(program), out_(out) {}

  /// False where the run ended before its time.
  bool kill_once(std::chrono::microseconds delay, bool from_first_line) {
    Child child(program_, {"run", "c.yaml", "--out", out_, "--resume"});
    const std::size_t size = rows().size() + journal().size();
    if (from_first_line)
      wait_until([&] { return !child.runs() || rows().size() + journal().size() != size; }, 400ms);
    std::this_thread::sleep_for(delay);
    child.send(SIGKILL);
    const int status = child.wait();
    EXPECT_TRUE(wait_until([&] { return child.processes() == 0; }, 20s))
        << "a worker outlives its run";
    check();
    if (WIFSIGNALED(status)) return true;
    EXPECT_EQ(status, 0) << program_.read("child-stderr");
    return false;
  }

  /// What is there is what was there, and more.
  void check() {
    const std::string rows_now = without_torn_line(rows()),
                      journal_now = without_torn_line(journal());
    EXPECT_TRUE(rows_now.starts_with(rows_)) << "a row was lost";
    rows_ = rows_now;
    std::map<std::string, int> ok;
    for (const json& row : whole_lines(rows_now))
      EXPECT_EQ(++ok[row["cell"].get<std::string>()], 1) << "a row was doubled";
    for (const auto& [cell, seconds] : rounds_in(journal_now)) {
      auto& before = journalled_[cell];
      EXPECT_GE(seconds.size(), before.size()) << "a round was lost";
      EXPECT_TRUE(std::equal(before.begin(), before.end(), seconds.begin()))
          << "a round was changed";
      EXPECT_LE(seconds.size(), 5u) << "a round too many";
      before = seconds;
    }
  }

  void finish(const std::vector<std::string>& expected) {
    const Outcome outcome = program_.run("run c.yaml --out " + out_ + " --resume");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    check();
    EXPECT_EQ(outcomes(rows()), expected);
    EXPECT_FALSE(std::filesystem::exists(program_ / (out_ + "/journal.jsonl")));
    EXPECT_FALSE(std::filesystem::exists(program_ / (out_ + "/scratch")));
    for (const json& row : whole_lines(rows())) {
      if (row["stage"] != "encode") continue;
      const auto samples = row["time"]["seconds"]["samples"].get<std::vector<double>>();
      const auto& kept = journalled_[row["cell"].get<std::string>()];
      ASSERT_GE(samples.size(), kept.size());
      EXPECT_TRUE(std::equal(kept.begin(), kept.end(), samples.begin()))
          << "a finished round is not in the row";
    }
  }

 private:
  std::string rows() const { return program_.read(out_ + "/rows.jsonl"); }
  std::string journal() const { return program_.read(out_ + "/journal.jsonl"); }

  const Program& program_;
  std::string out_, rows_;
  std::map<std::string, std::vector<double>> journalled_;
};

TEST_F(Kill, AHundredKillsLoseNothing) {
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(program_.run("run c.yaml --out reference").exit_code, 0);
  const auto whole = std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::steady_clock::now() - start);
  const auto expected = outcomes(program_.read("reference/rows.jsonl"));
  ASSERT_EQ(expected.size(), 5u);
  std::mt19937 random(20);
  const auto longest = std::clamp<std::int64_t>(whole.count(), 50'000, 300'000);
  int kills = 0, folders = 0, ended = 0;
  while (kills < 100 && ended < 200) {
    Campaign campaign(program_, fmt::format("o{}", folders++));
    for (int i = 0; i < 25 && kills < 100; ++i) {
      const bool late = random() % 2 == 0;
      const std::chrono::microseconds delay(static_cast<std::int64_t>(
          random() % static_cast<unsigned>(late ? longest / 4 : longest)));
      if (!campaign.kill_once(delay, late)) {
        ++ended;
        break;
      }
      ++kills;
    }
    campaign.finish(expected);
  }
  EXPECT_EQ(kills, 100);
  std::cout << kills << " kills in " << folders << " folders, " << ended
            << " runs ended before their kill\n";
}

TEST_F(Kill, SignalsEndTheWorkersAndLeaveWholeFiles) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    const std::string out = fmt::format("s{}", number);
    Child child(program_, {"run", "c.yaml", "--out", out}, kHang);
    ASSERT_TRUE(hangs(child, out));
    child.send(number);
    const int status = child.wait();
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == number) << status;
    EXPECT_TRUE(wait_until([&] { return child.processes() == 0; }, 20s));
    EXPECT_FALSE(std::filesystem::exists(program_ / (out + "/scratch")));
    const std::string rows = program_.read(out + "/rows.jsonl");
    EXPECT_EQ(without_torn_line(rows), rows);
    EXPECT_THAT(program_.read("child-stderr"), HasSubstr("--resume goes on"));
    EXPECT_EQ(program_.run("run c.yaml --resume --out " + out).exit_code, 0);
    EXPECT_EQ(whole_lines(program_.read(out + "/rows.jsonl")).size(), 5u);
  }
}

TEST_F(Kill, AShellSeesTheSignalInTheExitCode) {
  const std::string command = "cd " + (program_ / "") +
                              " && XDG_CACHE_HOME=" + (program_ / "cache") +
                              " CVRBENCH_TEST_FAULT='" + kHang +
                              "' timeout -s TERM 5 " CVRBENCH_FAULTY
                              " run c.yaml --out o >/dev/null 2>&1; test $? = 124 && "
                              "test ! -e o/scratch";
  EXPECT_EQ(std::system(command.c_str()), 0) << "timeout(1) sends the signal twice";
}

TEST_F(Kill, AStoppedRunGoesOnWithoutLosingACell) {
  Child child(program_, {"run", "c.yaml", "--out", "o"});
  for (int i = 0; i < 20; ++i) {
    std::this_thread::sleep_for(5ms);
    child.send(SIGSTOP);
    std::this_thread::sleep_for(5ms);
    child.send(SIGCONT);
  }
  EXPECT_EQ(child.wait(), 0);
  EXPECT_EQ(whole_lines(program_.read("o/rows.jsonl")).size(), 5u);
}

TEST_F(Kill, ARunIsRefusedWhereAnotherOneRunsBeforeItChangesAnything) {
  Child child(program_, {"run", "c.yaml", "--out", "o"}, kHang);
  ASSERT_TRUE(hangs(child));
  const std::string rows = program_.read("o/rows.jsonl"),
                    journal = program_.read("o/journal.jsonl");
  ASSERT_FALSE(journal.empty());
  const std::string program = CVRBENCH_PROGRAM;
  for (const std::string& command :
       {std::string("run c.yaml --out o --force"), std::string("run c.yaml --out o --resume"),
        std::string("aa c.yaml --out o"), "ab " + program + " " + program + " c.yaml --out o",
        std::string("baseline update c.yaml --out o --baseline b")}) {
    const Outcome refused = program_.run(command);
    EXPECT_EQ(refused.exit_code, 2) << command << refused.err;
    EXPECT_THAT(refused.err,
                HasSubstr("expected to be the only run that writes here, found another one"))
        << command;
    EXPECT_EQ(program_.read("o/rows.jsonl"), rows) << command;
    EXPECT_EQ(program_.read("o/journal.jsonl"), journal) << command;
    EXPECT_TRUE(std::filesystem::exists(program_ / "o/scratch")) << command;
  }
}

TEST_F(Kill, ARunIsRefusedInTheFoldersOfTwoPrograms) {
  Child child(program_, {"ab", CVRBENCH_FAULTY, CVRBENCH_FAULTY, "c.yaml", "--out", "o"}, kHang);
  ASSERT_TRUE(hangs(child, "o/b"));
  for (const char* folder : {"o", "o/a", "o/b"})
    EXPECT_EQ(program_.run(std::string("run c.yaml --force --out ") + folder).exit_code, 2)
        << folder;
}

TEST_F(Kill, ResumingAddsNoRowThatSaysWhatTheLastOneSays) {
  program_.write("m.yaml", std::string(kKilledConfig) +
                               "  - {datasets: [bonsai], codecs: [raw], stages: [encode]}\n");
  ASSERT_EQ(program_.run("run m.yaml --out o").exit_code, 0);
  const std::string rows = program_.read("o/rows.jsonl");
  EXPECT_THAT(rows, HasSubstr("\"unsupported\""));
  EXPECT_THAT(rows, HasSubstr("\"data-missing\""));
  for (int i = 0; i < 2; ++i) {
    const Outcome resumed = program_.run("run m.yaml --out o --resume");
    EXPECT_THAT(resumed.out, HasSubstr("1 unsupported"));
    EXPECT_EQ(program_.read("o/rows.jsonl"), rows);
  }
}

TEST_F(Kill, ForceMeasuresTheCellsOfEveryConfigurationAgain) {
  program_.write("a.yaml",
                 "rounds: 1\nmatrix:\n  - {datasets: [{generator: cells, extent: [9, 9, 9], name: "
                 "a}], codecs: [raw], stages: [encode]}\n");
  program_.write("b.yaml",
                 "rounds: 1\nmatrix:\n  - {datasets: [{generator: cells, extent: [9, 9, 9], name: "
                 "b, seed: 2}], codecs: [raw], stages: [encode]}\n");
  ASSERT_EQ(program_.run("run a.yaml b.yaml --out o").exit_code, 0);
  ASSERT_EQ(program_.run("run a.yaml b.yaml a.yaml --out o --force").exit_code, 0);
  EXPECT_EQ(whole_lines(program_.read("o/rows.jsonl")).size(), 8u)
      << "two of each, twice; the second a.yaml finds its cells done";
}

TEST_F(Kill, RoundsOfOtherConfigurationsStayInTheJournal) {
  const std::string line =
      R"({"cell": "0123456789abcdef 1", "origin": "x", "seconds": 1, "samples": [["s", 1, 1, 1]]})"
      "\n";
  program_.write("o/journal.jsonl", line);
  ASSERT_EQ(program_.run("run c.yaml --out o --resume --only codec=raw").exit_code, 0);
  EXPECT_THAT(program_.read("o/journal.jsonl"), testing::StartsWith(line));
}

TEST_F(Kill, RoundsBeyondTheLargestNumberAreLeftOut) {
  const char* many = " --set rounds=100000 --set max_rounds=100000 --set target_interval=0.000001";
  std::istringstream words(many);
  std::vector<std::string> arguments{"run", "c.yaml", "--out", "o"};
  for (std::string word; words >> word;) arguments.push_back(word);
  Child child(program_, arguments);
  ASSERT_TRUE(
      wait_until([&] { return std::ranges::count(program_.read("o/journal.jsonl"), '\n') >= 30; }));
  child.send(SIGTERM);
  child.wait();
  const auto journalled = rounds_in(program_.read("o/journal.jsonl"));
  ASSERT_EQ(program_
                .run("run c.yaml --out o --resume --only stage=encode --set rounds=3 --set "
                     "max_rounds=3 --set target_interval=0.000001")
                .exit_code,
            0);
  std::size_t left_out = 0;
  for (const json& row : whole_lines(program_.read("o/rows.jsonl"))) {
    if (row["stage"] != "encode") continue;
    const auto samples = row["time"]["seconds"]["samples"].get<std::vector<double>>();
    ASSERT_EQ(samples.size(), 3u);
    EXPECT_EQ(row["time"]["rounds"], 3);
    EXPECT_GT(row["memory"]["peak_bytes"].get<double>(), 1e6);
    const auto& kept = journalled.at(row["cell"].get<std::string>());
    EXPECT_TRUE(std::equal(samples.begin(), samples.end(), kept.begin()));
    const std::string stop = row["time"]["stop"];
    EXPECT_THAT(stop, HasSubstr(std::to_string(kept.size() - 3) +
                                " more of an interrupted run are left out"));
    ++left_out;
  }
  EXPECT_EQ(left_out, 3u);
}

TEST_F(Kill, FilesThatAKilledRunLeftAreRemovedByTheNextOneAndNoOthers) {
  for (const char* name :
       {"o/tables/t.md.part17", "o/tables/t.json.part17", "o/codecs.json.part17"})
    program_.write(name, "half a file");
  const std::vector<std::string> left = {"0123456789abcdef.cvr",
                                         "0123456789abcdef.cvr.99",
                                         "0123456789abcdef.picture",
                                         "0123456789abcdef.picture.99",
                                         "0123456789abcdef-fedcba9876543210.verified",
                                         "0123456789abcdef-fedcba9876543210.verified.99"};
  for (const std::string& name : left) program_.write("o/scratch/" + name, "half a file");
  program_.write("o/scratch/mine.txt", "the user's");
  program_.write("o/film.part1", "the user's");
  ASSERT_EQ(program_.run("run c.yaml --out o --only codec=raw --only stage=encode").exit_code, 0);
  for (const char* name :
       {"o/tables/t.md.part17", "o/tables/t.json.part17", "o/codecs.json.part17"})
    EXPECT_FALSE(std::filesystem::exists(program_ / name)) << name;
  for (const std::string& name : left)
    EXPECT_FALSE(std::filesystem::exists(program_ / ("o/scratch/" + name))) << name;
  EXPECT_TRUE(std::filesystem::exists(program_ / "o/scratch/mine.txt"));
  EXPECT_TRUE(std::filesystem::exists(program_ / "o/film.part1"));
}

}  // namespace
}  // namespace cvr::cli_tests
