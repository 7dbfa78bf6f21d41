// report: the page of a results folder, and what it says where something is missing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using testing::HasSubstr;

constexpr const char* kReportConfig = R"(title: T
rounds: 3
max_rounds: 3
lods: [0]
matrix:
  - datasets: [{generator: cells, extent: [24, 20, 16], name: blob}]
    codecs: [raw, zstd, csgvr-sb]
    stages: [encode, decode, random-access]
tables:
  - {name: t, title: Sizes of a blob, rows: [dataset, codec], columns: [rate, exact, status]}
claims:
  - {name: below-half, says: "smaller than half", source: "nowhere", metric: rate, left: {codec: csgvr-sb}, at_most: 50}
)";

class Report : public testing::Test {
 protected:
  Outcome report(const std::string& arguments) const {
    return program_.run("report " + arguments + " --store none");
  }
  Program program_;
};

TEST_F(Report, MakesAPageOfARun) {
  program_.write("c.yaml", kReportConfig);
  const Outcome measured = program_.run("run c.yaml --out o");
  ASSERT_EQ(measured.exit_code, 0) << measured.err;
  const Outcome outcome = report("--results o -o page.html --figures figures --title 'Of a blob'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string page = program_.read("page.html");
  EXPECT_THAT(page, HasSubstr("<title>Of a blob</title>"));
  EXPECT_THAT(page, HasSubstr("Which lossless codec is smallest?"));
  EXPECT_THAT(page, HasSubstr("csgvr-sb, "));
  EXPECT_THAT(page, HasSubstr("Sizes of a blob"));
  EXPECT_THAT(page, HasSubstr("From o/tables/t.json"));
  EXPECT_THAT(page, HasSubstr("below-half"));
  EXPECT_THAT(page, HasSubstr("no access to single voxels"));
  EXPECT_THAT(page, HasSubstr("id=\"figure-rate-access-"));
  EXPECT_THAT(page, HasSubstr("No row of stage render that is ok."));
  EXPECT_TRUE(std::filesystem::exists(program_ / "figures/rates-all.pdf"));
  EXPECT_TRUE(std::filesystem::exists(program_ / "figures/rates-all.svg"));
}

TEST_F(Report, SeveralFoldersMakeOnePage) {
  program_.write("a/rows.jsonl", "");
  program_.write("b/rows.jsonl", "{\"schema\": 1, \"cel");
  const Outcome outcome = report("--results a b --results a -o page.html");
  ASSERT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("nothing was measured"));
  EXPECT_THAT(program_.read("page.html"), HasSubstr("There are no rows"));
  EXPECT_THAT(program_.read("page.html"), HasSubstr("left out: line 1"));
}

TEST_F(Report, NamesWhatIsWrong) {
  program_.write("o/rows.jsonl", "");
  EXPECT_EQ(report("--results o").exit_code, 2);
  EXPECT_EQ(report("-o page.html").exit_code, 2);
  const Outcome missing = report("--results nowhere -o page.html");
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.err,
              HasSubstr("--results nowhere: expected a folder with rows.jsonl, found none"));
  const Outcome input = report("--results o -o o");
  EXPECT_EQ(input.exit_code, 2);
  EXPECT_THAT(input.err, HasSubstr("o: expected a folder without the input"));
  program_.write("f/file", "");
  const Outcome folder = report("--results o -o f");
  EXPECT_EQ(folder.exit_code, 3);
  EXPECT_THAT(folder.err, HasSubstr("f: cannot write: a folder has this name"));
  const Outcome rows = report("--results o -o o/rows.jsonl");
  EXPECT_EQ(rows.exit_code, 2);
  EXPECT_THAT(rows.err, HasSubstr("'o/rows.jsonl', which is read"));
  program_.write("o/codecs.json", "[]");
  const Outcome codecs = report("--results o -o o/codecs.json");
  EXPECT_EQ(codecs.exit_code, 2);
  EXPECT_THAT(codecs.err, HasSubstr("'o/codecs.json', which is read"));
  const Outcome unwritable = report("--results o -o nowhere/page.html");
  EXPECT_EQ(unwritable.exit_code, 3);
  EXPECT_THAT(unwritable.err, HasSubstr("nowhere/page.html"));
}

TEST_F(Report, NamesThePackagesThatAreMissing) {
  program_.write("o/rows.jsonl", "");
  // A module that fails to import stands before the real one.
  program_.write("hidden/matplotlib.py", "raise ImportError('hidden')\n");
  setenv("PYTHONPATH", (program_ / "hidden").c_str(), 1);
  const Outcome outcome = report("--results o -o page.html");
  unsetenv("PYTHONPATH");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err,
              HasSubstr("install the Debian packages python3-matplotlib and python3-jinja2"));
  EXPECT_FALSE(std::filesystem::exists(program_ / "page.html"));
}

}  // namespace
}  // namespace cvr::cli_tests
