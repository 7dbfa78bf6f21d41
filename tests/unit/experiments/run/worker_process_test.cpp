// Workers at the limits of the system. Their answers are tried in tests/cli/isolation_test.cpp.
#include "experiments/run/worker_process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>

#include "experiments/run/cell_failure.hpp"
#include "tests/samples/scratch_folder.hpp"

namespace cvr::experiments {
namespace {

using Wait = WorkerProcess::Wait;

class WorkerLimitsTest : public testing::Test {
 protected:
  std::string script(const std::string& text) const {
    const std::string path = folder_.write("worker.sh", "#!/bin/sh\n" + text + "\n");
    chmod(path.c_str(), 0755);
    return path;
  }
  ScratchFolder folder_;
};

TEST_F(WorkerLimitsTest, ProcessorTimeEndsAWorker) {
  const WorkerLimits limits{.cpu_seconds = 1};
  WorkerProcess worker(script("while :; do :; done"), limits);
  Row message;
  const Wait outcome = worker.receive(300, message);
  ASSERT_EQ(outcome, Wait::kEnd);
  const CellFailure failure = end_and_explain(worker, outcome, message, "round 2", 300, limits);
  EXPECT_EQ(failure.status, "timeout");
  EXPECT_EQ(failure.reason, "took more than 1 s of processor time by round 2");
}

TEST_F(WorkerLimitsTest, ALargerFileIsAnErrorOfItsWriteAndNoCrash) {
  WorkerProcess worker(script("head -c 100000 /dev/zero >" + (folder_ / "f") +
                              " 2>/dev/null; echo '{\"event\": \"ready\"}'"),
                       {.file_bytes = 8192});
  Row message;
  ASSERT_EQ(worker.receive(300, message), Wait::kMessage);
  EXPECT_EQ(message["event"], "ready");
  EXPECT_LE(std::filesystem::file_size(folder_ / "f"), 8192u);
}

TEST_F(WorkerLimitsTest, NoCoreDumps) {
  WorkerProcess worker(script("echo \"{\\\"event\\\": \\\"$(ulimit -c)\\\"}\""));
  Row message;
  ASSERT_EQ(worker.receive(300, message), Wait::kMessage);
  EXPECT_EQ(message["event"], "0");
}

TEST_F(WorkerLimitsTest, AnAnswerThatCameInTimeCountsHoweverLateItIsRead) {
  WorkerProcess worker(
      script("echo '{\"event\": \"ready\"}'; echo x >" + (folder_ / "done") + "; exec sleep 1000"));
  while (!std::filesystem::exists(folder_ / "done")) continue;
  Row message;
  EXPECT_EQ(worker.receive(0, message), Wait::kMessage);
  EXPECT_EQ(worker.receive(0, message), Wait::kTimeout);
  volatile std::sig_atomic_t interrupted = SIGTERM;
  EXPECT_EQ(worker.receive(300, message, &interrupted), Wait::kInterrupted);
}

}  // namespace
}  // namespace cvr::experiments
