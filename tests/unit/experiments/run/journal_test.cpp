#include "experiments/run/journal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "experiments/results/samples.hpp"
#include "tests/samples/scratch_folder.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

Round round_of(double seconds) {
  return {{{"encode", seconds, seconds / 2, 7}, {"step", 1, 1, 0}}, 2 * seconds};
}

class JournalTest : public testing::Test {
 protected:
  std::vector<double> seconds(const Journal& journal, const std::string& cell) const {
    std::vector<double> found;
    for (const Round& round : journal.rounds_of(cell))
      found.push_back(round.samples.at(0).wall_seconds);
    return found;
  }
  std::string error(const std::string& line) const {
    std::ofstream(path_)
        << R"({"cell": "a", "origin": "o", "seconds": 1, "samples": [["s", 1, 1, 1]]})"
        << "\n"
        << line << "\n";
    try {
      const Journal journal(path_, "o", false);
    } catch (const volumes::InputError& error) {
      return error.what();
    }
    return "no error";
  }
  ScratchFolder folder_;
  std::string path_ = folder_ / "journal.jsonl";
};

TEST_F(JournalTest, KeepsRoundsAcrossAKillInTheMiddleOfALine) {
  {
    Journal journal(path_, "this build", false);
    journal.append("a", round_of(0.1));
    journal.append("b", round_of(3));
    journal.append("a", round_of(4));
  }
  std::ofstream(path_, std::ios::app) << R"({"cell": "a", "origin": "this bu)";
  {
    Journal journal(path_, "this build", false);
    EXPECT_THAT(seconds(journal, "a"), testing::ElementsAre(0.1, 4));
    const Round& first = journal.rounds_of("a").at(0);
    EXPECT_EQ(first.seconds, 0.2);
    EXPECT_EQ(first.samples.at(0).series, "encode");
    EXPECT_EQ(first.samples.at(0).cpu_seconds, 0.05);
    EXPECT_EQ(first.samples.at(0).count, 7u);
    EXPECT_EQ(first.samples.size(), 2u);
    EXPECT_EQ(journal.rounds_of("b").size(), 1u);
    EXPECT_TRUE(journal.rounds_of("c").empty());
    journal.append("c", round_of(5));  // the torn line is cut off, so this is a line of its own
  }
  EXPECT_EQ(Journal(path_, "this build", false).rounds_of("c").size(), 1u);
}

TEST_F(JournalTest, ForgetsOtherBuildsAndOldRunsAndItself) {
  { Journal(path_, "that build", false).append("a", round_of(1)); }
  EXPECT_TRUE(Journal(path_, "this build", false).rounds_of("a").empty());
  EXPECT_TRUE(Journal(path_, "that build", true).rounds_of("a").empty());
  Journal(path_, "this build", false).remove({"a"});
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(JournalTest, StaysWhileItHoldsRoundsOfCellsThatHaveNotEnded) {
  { Journal(path_, "other configuration", false).append("b hash", round_of(2)); }
  {
    Journal journal(path_, "this build", false);
    journal.append("a hash", round_of(1));
    journal.remove({"a"});
  }
  EXPECT_EQ(Journal(path_, "other configuration", false).rounds_of("b hash").size(), 1u);
  Journal(path_, "this build", false).remove({"b", "a"});
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(JournalTest, AWholeLineThatIsNoRoundIsAnErrorWithItsPlace) {
  using testing::HasSubstr;
  EXPECT_THAT(error("nonsense"), HasSubstr("journal.jsonl:2:2: expected JSON"));
  EXPECT_THAT(error(std::string(300000, '[')),
              HasSubstr("journal.jsonl:2:65: expected JSON of at most 64 levels"));
  for (const char* line :
       {"[]", "7", R"({"cell": "a"})", R"({"cell": 1, "origin": "o", "seconds": 1, "samples": []})",
        R"({"cell": "a", "origin": "o", "seconds": 1, "samples": []})",
        R"({"cell": "a", "origin": "o", "seconds": 1, "samples": [["s", 1, 1]]})",
        R"({"cell": "a", "origin": "o", "seconds": 1, "samples": [["s", -1, 1, 1]]})",
        R"({"cell": "a", "origin": "o", "seconds": 1, "samples": [["s", null, 1, 1]]})",
        R"({"cell": "a", "origin": "o", "seconds": 1, "samples": [["s", 1, 1, -1]]})",
        R"({"cell": "a", "origin": "o", "seconds": "1", "samples": [["s", 1, 1, 1]]})",
        R"({"cell": "a", "origin": "o", "samples": [["s", 1, 1, 1]]})"}) {
    EXPECT_THAT(error(line), HasSubstr("journal.jsonl:2: expected a round")) << line;
  }
  EXPECT_THAT(
      error(
          R"({"cell": "a", "cell": "b", "origin": "o", "seconds": 1, "samples": [["s", 1, 1, 1]]})"),
      HasSubstr("expected each key once"));
  EXPECT_EQ(error(R"({"cell": "a", "origin": "of another build", "samples": "unknown"})"),
            "no error");
}

}  // namespace
}  // namespace cvr::experiments
