#include "experiments/journal.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "scratch_folder.hpp"

namespace cvr::experiments {
namespace {

class JournalTest : public testing::Test {
 protected:
  ScratchFolder folder_;
  std::string path_ = folder_ / "journal.jsonl";
};

TEST_F(JournalTest, KeepsRoundsAcrossAKillInTheMiddleOfALine) {
  {
    Journal journal(path_, "this build", false);
    journal.append("a", Row::array({1, 2}));
    journal.append("b", Row::array({3}));
    journal.append("a", Row::array({4}));
  }
  std::ofstream(path_, std::ios::app) << R"({"cell": "a", "origin": "this bu)";
  {
    Journal journal(path_, "this build", false);
    EXPECT_EQ(journal.rounds_of("a"), (std::vector<Row>{Row::array({1, 2}), Row::array({4})}));
    EXPECT_EQ(journal.rounds_of("b").size(), 1u);
    EXPECT_TRUE(journal.rounds_of("c").empty());
    journal.append("c", Row::array({5}));  // the torn line is cut off, so this is a line of its own
  }
  EXPECT_EQ(Journal(path_, "this build", false).rounds_of("c").size(), 1u);
}

TEST_F(JournalTest, ForgetsOtherBuildsAndOldRunsAndItself) {
  { Journal(path_, "that build", false).append("a", Row::array({1})); }
  EXPECT_TRUE(Journal(path_, "this build", false).rounds_of("a").empty());
  EXPECT_TRUE(Journal(path_, "that build", true).rounds_of("a").empty());
  Journal(path_, "this build", false).remove();
  EXPECT_FALSE(std::filesystem::exists(path_));
}

}  // namespace
}  // namespace cvr::experiments
