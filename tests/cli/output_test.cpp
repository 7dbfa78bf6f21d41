// What every command that writes promises: an output that cannot be written is exit code 3 with its
// name and the reason, inputs are never replaced, lost standard output is never exit code 0, and a
// signal leaves nothing unfinished.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::vector<std::string> kVolumes{"o.h5",     "o.nrrd", "o.nhdr",       "o.nii",
                                        "o.nii.gz", "o.raw",  "o.precomputed"};

class Output : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(program_.run("generate cells --size 20,17,13 --seed 1 -o v.raw").exit_code, 0);
    ASSERT_EQ(program_.run("encode v.raw -o v.cvr --codec raw").exit_code, 0);
  }
  /// Every command that writes a file, with the name that it writes.
  static std::vector<std::pair<std::string, std::string>> writing(const std::string& folder) {
    std::vector<std::pair<std::string, std::string>> commands;
    for (const std::string& name : kVolumes) {
      const std::string out = folder + name;
      commands.emplace_back("generate worst-case --size 40,40,40 --seed 1 -o " + out, out);
      commands.emplace_back("convert v.raw " + out, out);
      commands.emplace_back("decode v.cvr -o " + out, out);
    }
    commands.emplace_back("encode v.raw --codec raw -o " + folder + "o.cvr", folder + "o.cvr");
    return commands;
  }
  /// One line on standard error that holds `text`, nothing half-written, this exit code.
  void expect_failure(const std::string& command, int exit_code, const std::string& text) {
    SCOPED_TRACE(command);
    const Outcome outcome = program_.run(command);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_EQ(unfinished(), "");
  }
  /// The names below the test's folder that are temporary ones.
  std::string unfinished() const {
    std::string names;
    for (const auto& entry : fs::recursive_directory_iterator(program_ / "")) {
      const std::string name = entry.path().filename().string();
      if (name.find(".part") != std::string::npos || name.find(".old") != std::string::npos)
        names += name + " ";
    }
    return names;
  }
  Program program_;
};

TEST_F(Output, MissingFoldersAndFoldersInTheWayAreExitCodeThree) {
  for (const auto& [command, name] : writing("none/"))
    expect_failure(command, 3, name + ": cannot write: there is no folder 'none'");
  for (const auto& [command, name] : writing("taken/")) {
    fs::create_directories(program_ / name);
    program_.write(name + "/mine", "mine");
    expect_failure(command, 3, name + ": cannot write: ");
    EXPECT_EQ(program_.read(name + "/mine"), "mine");
  }
  for (const std::string& command : {std::string("encode v.raw --codec raw -o /dev/null"),
                                     std::string("encode v.raw --codec raw -o /dev/full")}) {
    expect_failure(command, 3, "/dev/");
  }
  ASSERT_EQ(mkfifo((program_ / "pipe").c_str(), 0600), 0);
  expect_failure("encode v.raw --codec raw -o pipe", 3, "a device, pipe or socket");
  EXPECT_TRUE(fs::is_fifo(program_ / "pipe"));
}

/// The shell's limit counts KiB (or half ones); each output is larger.
TEST_F(Output, AFileSizeLimitIsAnErrorAndNoSignal) {
  for (const auto& [command, name] : writing("")) {
    if (name == "o.h5") continue;  // tests of HDF5 show its own
    const bool packed = name == "o.precomputed" || name == "o.nrrd" || name == "o.nii.gz";
    if (packed && !command.starts_with("generate")) continue;  // smaller than the limit
    SCOPED_TRACE(command);
    const Outcome outcome =
        program_.run("--version > /dev/null; ulimit -f 2; " CVRBENCH_PROGRAM " " + command);
    EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("File too large"));
    EXPECT_FALSE(fs::exists(program_ / name));
    EXPECT_EQ(unfinished(), "");
  }
}

TEST_F(Output, AFullDiskIsAnErrorForEveryWriter) {
  fs::create_directory(program_ / "full");
  if (mount("none", (program_ / "full").c_str(), "tmpfs", 0, "size=16k") != 0)
    GTEST_SKIP() << "mounting a small file system needs root";
  for (const auto& [command, name] : writing("full/")) {
    if (name.ends_with(".h5")) continue;  // tests of HDF5 show its own
    SCOPED_TRACE(command);
    const Outcome outcome = program_.run(command);
    // What compresses to less than the disk has is written.
    if (outcome.exit_code == 0) {
      fs::remove_all(program_ / name);
      fs::remove(program_ / (name + ".bin"));
      fs::remove(program_ / (name + ".yaml"));
      continue;
    }
    EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(name));
    EXPECT_TRUE(fs::is_empty(program_ / "full"));
    fs::remove_all(program_ / name);
  }
  umount((program_ / "full").c_str());
}

TEST_F(Output, InputsAreNeverReplaced) {
  ASSERT_EQ(program_.run("convert v.raw p.precomputed").exit_code, 0);
  const std::string voxels = program_.read("v.raw"), sidecar = program_.read("v.raw.yaml"),
                    encoded = program_.read("v.cvr");
  fs::create_symlink("p.precomputed", program_ / "link");
  fs::create_symlink("v.cvr", program_ / "link.raw");
  fs::create_hard_link(program_ / "v.cvr", program_ / "hard.nrrd");
  for (const std::string command :
       {"encode p.precomputed --codec raw -o p.precomputed/info",
        "encode link/ --codec raw -o p.precomputed/new.cvr", "convert p.precomputed p.precomputed",
        "convert p.precomputed link/", "convert p.precomputed p.precomputed/a.h5",
        "decode v.cvr -o link.raw", "decode v.cvr -o hard.nrrd"}) {
    expect_failure(command, 2, "which is read");
  }
  EXPECT_EQ(program_.read("v.raw"), voxels);
  EXPECT_EQ(program_.read("v.raw.yaml"), sidecar);
  EXPECT_EQ(program_.read("v.cvr"), encoded);
  EXPECT_EQ(program_.run("error v.raw p.precomputed").exit_code, 0);
  EXPECT_THAT(program_.run("convert v.raw emptydir").err,
              HasSubstr("expected the name of a volume"));
}

TEST_F(Output, LostStandardOutputIsNeverExitCodeZero) {
  for (const std::string command :
       {"--help", "--version", "encode --help", "list codecs", "list metrics --json",
        "inspect v.cvr", "inspect v.raw", "at v.cvr 0 0 0", "error v.raw v.cvr --json",
        "validate v.cvr", "encode v.raw -o w.cvr --codec raw"}) {
    SCOPED_TRACE(command);
    const Outcome full = program_.run(command + " > /dev/full");
    EXPECT_EQ(full.exit_code, 3);
    EXPECT_THAT(full.err,
                HasSubstr("cvrbench: standard output: cannot write: No space left on device"));
    EXPECT_EQ(std::ranges::count(full.err, '\n'), 1) << full.err;
    const Outcome closed = program_.run(command + " >&-");
    EXPECT_EQ(closed.exit_code, 3);
    EXPECT_THAT(closed.err, HasSubstr("standard output: cannot write: it is closed"));
    EXPECT_EQ(program_.run(command + " > told").exit_code, 0);
    EXPECT_GT(fs::file_size(program_ / "told"), 0u);
  }
}

/// What is opened first must not get the number of a closed descriptor and receive what is printed.
TEST_F(Output, ClosedDescriptorsTakeNothingFromOutputs) {
  EXPECT_EQ(program_.run("convert v.raw w.raw <&- >&-").exit_code, 0)
      << "nothing was printed, nothing is lost";
  EXPECT_EQ(program_.read("w.raw"), program_.read("v.raw"));
  EXPECT_EQ(program_.run("encode v.raw -o w.cvr --codec raw <&- >&-").exit_code, 3)
      << "the report is lost";
  EXPECT_EQ(program_.read("w.cvr"), program_.read("v.cvr"));
  const Outcome silent = program_.run("convert none.raw x.raw 2>&-");
  EXPECT_EQ(silent.exit_code, 2);
}

TEST_F(Output, AReaderThatWentAwayEndsTheProgramQuietly) {
  // The fifo's reader is closed before the program writes.
  for (const std::string setting : {"", "trap '' PIPE; "}) {
    const Outcome outcome =
        program_.run("--version > /dev/null; " + setting +
                     "{ sleep 0.3; " CVRBENCH_PROGRAM
                     " list codecs 2> complaints; echo $? > code; } | true; cat code");
    EXPECT_EQ(outcome.out, "141\n") << setting;
    EXPECT_EQ(program_.read("complaints"), "") << setting;
  }
}

/// Starts a command, waits until it has an unfinished output, sends the signal. The exit code as a
/// shell sees it.
int interrupted(const Program& program, const std::string& command, const std::string& signal_name,
                const std::string& partial) {
  const std::string line =
      "--version > /dev/null; " CVRBENCH_PROGRAM " " + command + " & child=$!; n=0; while [ ! -e " +
      partial + " ] && kill -0 $child && [ $n -lt 600 ]; do sleep 0.05; n=$((n+1)); done; kill -" +
      signal_name + " $child; wait $child; echo $?";
  const Outcome outcome = program.run(line);
  return std::atoi(outcome.out.c_str());
}

TEST_F(Output, ASignalLeavesNothingUnfinished) {
  struct Case {
    std::string signal;
    int exit_code;
  };
  program_.write("old.nii.gz", "old");
  // A shell starts background jobs with SIGINT ignored, which the program obeys; the other two go
  // the same way.
  for (const Case& c : {Case{"TERM", 143}, Case{"HUP", 129}}) {
    for (const std::string& name :
         {std::string("old.nii.gz"), std::string("n.raw"), std::string("n.precomputed")}) {
      SCOPED_TRACE(name + " " + c.signal);
      EXPECT_EQ(
          interrupted(program_, "generate cells --size 400,400,400 --seed 1 --threads 1 -o " + name,
                      c.signal, name + ".part0"),
          c.exit_code);
      EXPECT_EQ(unfinished(), "");
    }
  }
  EXPECT_EQ(program_.read("old.nii.gz"), "old");
  EXPECT_FALSE(fs::exists(program_ / "n.raw"));
  EXPECT_FALSE(fs::exists(program_ / "n.precomputed"));
}

/// As a terminal sends it: to a program whose SIGINT is not ignored.
TEST_F(Output, CtrlCIsExitCode130) {
  const pid_t child = fork();
  if (child == 0) {
    if (chdir((program_ / "").c_str()) != 0) _exit(99);
    signal(SIGINT, SIG_DFL);
    execl(CVRBENCH_PROGRAM, CVRBENCH_PROGRAM, "generate", "cells", "--size", "400,400,400",
          "--seed", "1", "-o", "n.nrrd", nullptr);
    _exit(98);
  }
  for (int i = 0; i < 600 && !fs::exists(program_ / "n.nrrd.part0"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) << status;
  EXPECT_EQ(unfinished(), "");
  EXPECT_FALSE(fs::exists(program_ / "n.nrrd"));
}

}  // namespace
}  // namespace cvr::cli_tests
