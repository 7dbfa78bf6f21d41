// leaderboard: a run becomes a site; what is refused, and what stays then.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using testing::HasSubstr;

constexpr const char* kLeaderboardConfig = R"(title: T
rounds: 3
max_rounds: 3
lods: [0]
matrix:
  - datasets: [{generator: cells, extent: [24, 20, 16], name: blob}]
    codecs: [raw, zstd, csgvr-sb]
    stages: [encode, decode, random-access]
)";

class Leaderboard : public testing::Test {
 protected:
  bool exists(const std::string& name) const { return std::filesystem::exists(program_ / name); }
  Outcome make(const std::string& arguments) const {
    return program_.run("leaderboard " + arguments);
  }
  Program program_;
};

TEST_F(Leaderboard, ARunBecomesASiteThatIsReplacedAsAWhole) {
  program_.write("c.yaml", kLeaderboardConfig);
  const Outcome measured = program_.run("run c.yaml --out o");
  ASSERT_EQ(measured.exit_code, 0) << measured.err;
  const Outcome outcome = make("o -o site --title 'Of a blob'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Site: site/index.html"));
  const std::string index = program_.read("site/index.html");
  EXPECT_THAT(index, HasSubstr("<title>Of a blob</title>"));
  EXPECT_THAT(index, HasSubstr("dataset/blob-24x20x16.html"));
  EXPECT_THAT(index, HasSubstr("no access to single voxels"));
  EXPECT_THAT(program_.read("site/codec/csgvr-sb.html"), HasSubstr("Where it stands"));
  EXPECT_THAT(program_.read("site/dataset/blob-24x20x16.html"), HasSubstr("<svg"));
  EXPECT_TRUE(exists("site/rows/blob-24x20x16.jsonl.gz"));

  const Outcome again = make("o -o site");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(program_.read("site/index.html"), HasSubstr("Compressed volumes: leaderboard"));
  EXPECT_FALSE(exists("site.part0"));

  program_.write("site/notes.txt", "mine");
  const Outcome refused = make("o -o site");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("found 'notes.txt'"));
  EXPECT_EQ(program_.read("site/notes.txt"), "mine");
}

TEST_F(Leaderboard, NamesWhatIsWrong) {
  program_.write("empty/note", "");
  program_.write("none/rows.jsonl", R"({"status": "failed", "stage": "encode"})");
  program_.write("file", "no pack");
  EXPECT_EQ(make("none").exit_code, 2);
  EXPECT_EQ(make("-o site").exit_code, 2);
  const Outcome missing = make("nowhere -o site");
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.err, HasSubstr("nowhere: expected a results folder or a pack, found none"));
  const Outcome rowless = make("empty -o site");
  EXPECT_EQ(rowless.exit_code, 2);
  EXPECT_THAT(rowless.err, HasSubstr("empty: expected rows.jsonl"));
  const Outcome damaged = make("file -o site");
  EXPECT_EQ(damaged.exit_code, 2);
  EXPECT_THAT(damaged.err, HasSubstr("file: no pack that can be read"));
  const Outcome nothing = make("none -o site");
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("no row of these results is ok"));
  const Outcome own = make("none -o none");
  EXPECT_EQ(own.exit_code, 2);
  EXPECT_THAT(own.err, HasSubstr("expected a folder without the results"));
  const Outcome full = make("none -o empty");
  EXPECT_EQ(full.exit_code, 2);
  EXPECT_THAT(full.err, HasSubstr("found 'note'"));
  EXPECT_EQ(make("none -o nowhere/site").exit_code, 3);
  EXPECT_FALSE(exists("site"));
  EXPECT_FALSE(exists("site.part0"));
}

}  // namespace
}  // namespace cvr::cli_tests
