// What control groups leave, from folders as the kernel shows them.
#include "experiments/run/memory.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <string>

namespace cvr::experiments {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kEverything = ~std::uint64_t{0};

class ControlGroups : public testing::Test {
 protected:
  ControlGroups() { fs::create_directories(mount()); }
  ~ControlGroups() override { fs::remove_all(root_); }

  fs::path mount() const { return root_ / "cgroup"; }
  void write(const fs::path& path, const std::string& text) const {
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  void member_of(const std::string& text) const { write(root_ / "membership", text); }
  /// A group of version 2.
  void group(const fs::path& name, const std::string& most, std::uint64_t used,
             std::uint64_t inactive = 0) const {
    write(mount() / name / "memory.max", most + '\n');
    write(mount() / name / "memory.current", std::to_string(used) + '\n');
    write(mount() / name / "memory.stat", "anon 7\nfile 9\ninactive_anon 3\ninactive_file " +
                                              std::to_string(inactive) + "\nactive_file 5\n");
  }
  /// A group of version 1. Its own inactive_file is not that of the groups below.
  void group_v1(const fs::path& name, std::uint64_t most, std::uint64_t used,
                std::uint64_t inactive = 0) const {
    const fs::path folder = mount() / "memory" / name;
    write(folder / "memory.limit_in_bytes", std::to_string(most) + '\n');
    write(folder / "memory.usage_in_bytes", std::to_string(used) + '\n');
    write(folder / "memory.stat", "cache 1\ninactive_file 1\ntotal_cache 9\ntotal_inactive_file " +
                                      std::to_string(inactive) + '\n');
  }
  std::uint64_t left() const { return left_of_control_groups(root_ / "membership", mount()); }

 private:
  fs::path root_ =
      fs::temp_directory_path() / ("control_groups_" + std::to_string(getpid()) + '_' +
                                   testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(ControlGroups, WithoutFilesThereIsNoLimit) {
  EXPECT_EQ(left(), kEverything);
  member_of("0::/user.slice\n");
  EXPECT_EQ(left(), kEverything);
}

TEST_F(ControlGroups, Version2TakesTheLeastOfAGroupAndThoseAbove) {
  member_of("0::/user.slice/session.scope\n");
  group("user.slice/session.scope", std::to_string(800 * kMiB), 100 * kMiB);
  EXPECT_EQ(left(), 700 * kMiB);
  group("user.slice", std::to_string(500 * kMiB), 300 * kMiB);
  EXPECT_EQ(left(), 200 * kMiB);
  group("user.slice", "max", 300 * kMiB);
  EXPECT_EQ(left(), 700 * kMiB);
  group("other.slice", std::to_string(kMiB), kMiB);
  EXPECT_EQ(left(), 700 * kMiB) << "a group that the process is not in";
}

TEST_F(ControlGroups, Version2DoesNotCountFilesThatWereNotReadLately) {
  member_of("0::/a\n");
  group("a", std::to_string(800 * kMiB), 790 * kMiB, 600 * kMiB);
  EXPECT_EQ(left(), 610 * kMiB);
  group("a", std::to_string(800 * kMiB), 790 * kMiB, 900 * kMiB);
  EXPECT_EQ(left(), 800 * kMiB) << "more of them than is used: read at different moments";
}

TEST_F(ControlGroups, AGroupBeyondItsLimitLeavesNothing) {
  member_of("0::/a\n");
  group("a", std::to_string(10 * kMiB), 11 * kMiB);
  EXPECT_EQ(left(), 0u);
}

TEST_F(ControlGroups, AContainersGroupIsTheMount) {
  member_of("0::/\n");
  group("", std::to_string(64 * kMiB), 4 * kMiB);
  EXPECT_EQ(left(), 60 * kMiB);
  member_of("0::/docker/of-the-host\n");
  EXPECT_EQ(left(), 60 * kMiB);
}

TEST_F(ControlGroups, Version1HasAControllerOfMemory) {
  member_of(
      "12:pids:/docker/abc\n5:cpu,cpuacct:/docker/abc\n4:memory:/docker/abc\n"
      "1:name=systemd:/docker/abc\n");
  group_v1("docker/abc", 512 * kMiB, 500 * kMiB, 100 * kMiB);
  EXPECT_EQ(left(), 112 * kMiB);
  group_v1("", 0x7ffffffffffff000, 900 * kMiB);  // how version 1 says that there is no limit
  EXPECT_EQ(left(), 112 * kMiB);
  group_v1("docker", 300 * kMiB, 250 * kMiB);
  EXPECT_EQ(left(), 50 * kMiB);
}

TEST_F(ControlGroups, OfBothVersionsTheLeastCounts) {
  member_of("7:memory:/a\n0::/a\n");
  group_v1("a", 512 * kMiB, 500 * kMiB);
  group("a", std::to_string(512 * kMiB), 100 * kMiB);
  EXPECT_EQ(left(), 12 * kMiB);
  group("a", std::to_string(105 * kMiB), 100 * kMiB);
  EXPECT_EQ(left(), 5 * kMiB);
}

}  // namespace
}  // namespace cvr::experiments
