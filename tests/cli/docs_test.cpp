// docs: markers and pages from the rows of a run that was just measured, and from what is none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kConfig = R"(title: T
rounds: 1
max_rounds: 1
matrix:
  - datasets: [{generator: cells, extent: [16, 16, 16], name: blob}]
    codecs: [raw, zstd]
    stages: [encode]
tables:
  - {name: t, title: Sizes of a blob, rows: [dataset, codec], columns: [rate, exact]}
)";
constexpr const char* kText =
    "Raw: <!--cvrbench {run: r, value: rate, decimals: 0, where: {codec: raw}}-->?<!--/cvrbench-->"
    " %.\n";

class Docs : public testing::Test {
 protected:
  Docs() {
    program_.write("evidence/r/r.yaml", kConfig);
    program_.write("d.md", kText);
    measured_ = program_.run("run evidence/r/r.yaml --out evidence/r");
  }
  Outcome docs(const std::string& arguments) const {
    return program_.run("docs --evidence evidence " + arguments);
  }
  Program program_;
  Outcome measured_;
};

TEST_F(Docs, MarkersAndPagesAreMadeOnceAndCheckedAfterwards) {
  ASSERT_EQ(measured_.exit_code, 0) << measured_.err;
  const Outcome stale = docs("d.md --pages pages --check");
  EXPECT_EQ(stale.exit_code, 1);
  EXPECT_THAT(stale.err, HasSubstr("d.md:1: differs from its rows"));
  EXPECT_FALSE(fs::exists(program_ / "pages"));
  const Outcome written = docs("d.md --pages pages");
  ASSERT_EQ(written.exit_code, 0) << written.err;
  EXPECT_EQ(written.out, "d.md\npages/r.md\npages/README.md\n");
  EXPECT_THAT(program_.read("d.md"), HasSubstr("-->10"));
  EXPECT_THAT(program_.read("pages/r.md"), HasSubstr("## Sizes of a blob\n"));
  EXPECT_THAT(program_.read("pages/README.md"), HasSubstr("| [r](r.md) | T | "));
  const Outcome again = docs("d.md --pages pages");
  EXPECT_EQ(again.out, "");
  EXPECT_EQ(docs("d.md --pages pages --check").exit_code, 0);
}

TEST_F(Docs, FiguresThatRowsDoNotSayAreFound) {
  ASSERT_EQ(measured_.exit_code, 0) << measured_.err;
  ASSERT_EQ(docs("d.md").exit_code, 0);
  std::string typed = program_.read("d.md");
  typed.replace(typed.find("-->1") + 3, 1, "7");
  program_.write("d.md", "\n" + typed);
  const Outcome outcome = docs("d.md --check");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("d.md:2: differs from its rows"));
  EXPECT_EQ(program_.read("d.md"), "\n" + typed);
}

TEST_F(Docs, MistakesAreErrorsOfTheInputAndChangeNothing) {
  ASSERT_EQ(measured_.exit_code, 0) << measured_.err;
  const Outcome no_folder = program_.run("docs d.md --evidence none");
  EXPECT_EQ(no_folder.exit_code, 2);
  EXPECT_THAT(no_folder.err, HasSubstr("--evidence none: expected a folder of runs"));
  program_.write("e.md", "<!--cvrbench {run: ../evidence/r, cells: ok}--><!--/cvrbench-->");
  EXPECT_EQ(docs("e.md").exit_code, 2);
  program_.write("e.md", "<!--cvrbench {run: s, cells: ok}-->x<!--/cvrbench-->");
  const Outcome no_run = docs("e.md");
  EXPECT_EQ(no_run.exit_code, 2);
  EXPECT_THAT(no_run.err, HasSubstr("e.md:1: marker of s: expected the configuration"));
  EXPECT_THAT(program_.read("e.md"), HasSubstr(">x<"));
  EXPECT_EQ(docs("absent.md").exit_code, 2);
}

}  // namespace
}  // namespace cvr::cli_tests
