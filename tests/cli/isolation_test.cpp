// What a worker may do to a run: nothing. Workers are shell scripts here that break for the codec
// zstd and hand all other cells to the real program; each break is a row with its reason, and the
// cells beside it are ok.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "experiments/run/load_config.hpp"
#include "experiments/run/runner.hpp"
#include "tests/cli/child.hpp"
#include "volumes/error.hpp"

namespace cvr::cli_tests {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using namespace experiments;

constexpr const char* kIsolationConfig = R"(title: I
rounds: 2
max_rounds: 2
timeout_s: 60
lods: [0]
matrix:
  - datasets: [{generator: cells, extent: [16, 12, 9], name: blob}]
    codecs: [raw, zstd]
    stages: [encode]
)";

class Isolation : public testing::Test {
 protected:
  void SetUp() override {
    signal(SIGPIPE, SIG_IGN);  // as the command line has it
    program_.write("c.yaml", kIsolationConfig);
  }

  /// A worker of which cells of zstd do `fault`, in the language of the shell, after their order
  /// has been read.
  std::string script(const std::string& fault) const {
    program_.write(
        "worker.sh",
        "#!/bin/sh\nread -r line\ncase \"$line\" in\n  *'\"codec\":\"zstd\"'*) " + fault +
            ";;\n  *) { printf '%s\\n' \"$line\"; cat; } | " CVRBENCH_PROGRAM " worker;;\nesac\n");
    chmod((program_ / "worker.sh").c_str(), 0755);
    return program_ / "worker.sh";
  }

  /// Rows by codec.
  std::map<std::string, json> run(const std::string& fault,
                                  const std::string& setting = "timeout_s=60") {
    const std::string out = program_ / (fmt::format("o{}", runs_++));
    RunOptions options;
    options.contenders = {{script(fault), out}};
    options.places = {"", program_ / "cache"};
    const Config config = load_config(program_ / "c.yaml", Catalogue(), {setting});
    summary_ = run_config(config, options);
    std::map<std::string, json> rows;
    for (const Result& result : load_rows(out + "/rows.jsonl"))
      rows[result.codec.id] = to_json(result);
    return rows;
  }

  /// The row of zstd; the others are ok.
  json broken(const std::string& fault, const std::string& setting = "timeout_s=60") {
    auto rows = run(fault, setting);
    EXPECT_EQ(rows.size(), 3u);
    for (const char* other : {"memcpy", "raw"})
      EXPECT_EQ(rows[other]["status"], "ok") << fault << rows[other].dump();
    return rows["zstd"];
  }

  Program program_;
  RunSummary summary_;
  int runs_ = 0;
};

TEST_F(Isolation, EndlessOutputIsCutOff) {
  const json row = broken("exec tr '\\0' x </dev/zero");
  EXPECT_EQ(row["status"], "failed");
  EXPECT_THAT(row["reason"].get<std::string>(),
              AllOf(HasSubstr("gave an answer to the check that is none: 'xxxx"),
                    testing::SizeIs(testing::Le(200u))));
}

TEST_F(Isolation, EndlessComplaintsAreATimeOutAndTakeNoMemory) {
  const json row = broken("yes >&2; true", "timeout_s=2");
  EXPECT_EQ(row["status"], "timeout") << row["reason"];
}

TEST_F(Isolation, ComplaintsDoNotHoldUpAWorkerAndItsLastWordsAreTold) {
  const json row = broken("yes | head -c 3000000 >&2; printf 'last\\twords\\n' >&2; exit 7");
  EXPECT_THAT(row["reason"].get<std::string>(),
              AllOf(HasSubstr("exit code 7"), HasSubstr("last\\twords"),
                    testing::SizeIs(testing::Le(2000u))));
}

TEST_F(Isolation, WhatIsNoAnswerIsARow) {
  const std::string deep(300000, '[');
  program_.write("deep.txt", deep + "\n");
  const std::string ready = "echo '{\"event\":\"ready\",\"parts\":{}}'; read -r round; ";
  for (const std::string& fault :
       {std::string("echo hello; exec sleep 1000"), std::string("echo '[1]'"),
        std::string("echo '{\"event\": 7}'"),
        std::string("echo '{\"event\":\"ready\",\"parts\":5}'"),
        std::string("echo '{\"event\":\"failure\",\"status\":3}'"),
        std::string("echo '{\"event\":\"failure\",\"status\":\"ok\",\"reason\":\"fine\"}'"),
        "cat " + (program_ / "deep.txt"), ready + "echo '{\"event\":\"round\",\"samples\":[]}'",
        ready + "echo '{\"event\":\"round\",\"samples\":[[\"encode\",-1,0,1]]}'",
        ready + "echo '{\"event\":\"round\"}'"}) {
    const json row = broken(fault);
    EXPECT_EQ(row["status"], "failed") << fault;
    EXPECT_THAT(row["reason"].get<std::string>(), HasSubstr("that is none")) << fault;
    EXPECT_FALSE(row.contains("time"));
  }
}

TEST_F(Isolation, PartsNeverReplaceWhatTheRunKnows) {
  const auto with_parts = [&](const std::string& parts) {
    return broken("echo '{\"event\":\"ready\",\"parts\":" + parts +
                  "}'; while read -r line; do [ \"$line\" = stop ] && exit 0; "
                  "echo '{\"event\":\"round\",\"samples\":[[\"encode\",1,1,1]]}'; done");
  };
  for (const char* parts : {R"({"status":5})", R"({"cell":"x"})", R"({"key":[]})",
                            R"({"time":"never"})", R"({"access":{}})"}) {
    const json row = with_parts(parts);
    EXPECT_EQ(row["status"], "failed") << parts;
    EXPECT_THAT(row["reason"].get<std::string>(), HasSubstr("gave answers that are none")) << parts;
  }
  EXPECT_EQ(with_parts(R"({"frames":{},"access":[],"later":5})")["status"], "ok");
}

TEST_F(Isolation, AnEndBeforeTheAnswerIsARow) {
  EXPECT_THAT(broken("exit 0")["reason"].get<std::string>(),
              HasSubstr("crashed in the check: exit code 0"));
  EXPECT_EQ(broken("kill -9 $$")["status"], "out-of-memory");
  EXPECT_THAT(broken("kill -SEGV $$")["reason"].get<std::string>(), HasSubstr("signal 11"));
}

TEST_F(Isolation, AWorkerThatSaysNoMoreButDoesNotEndIsARow) {
  EXPECT_THAT(broken("exec sleep 1000 >&2")["reason"].get<std::string>(),
              HasSubstr("said no more in the check and did not end"));
}

TEST_F(Isolation, WhatAWorkerStartedEndsWithIt) {
  broken("sleep 1000 & echo $! >" + (program_ / "pid") + "; wait", "timeout_s=3");
  const std::string pid = program_.read("pid");
  ASSERT_FALSE(pid.empty());
  const std::string stat = "/proc/" + pid.substr(0, pid.find('\n')) + "/stat";
  EXPECT_TRUE(wait_until(
      [&] {
        std::ifstream in(stat);
        const std::string text{std::istreambuf_iterator<char>(in), {}};
        return text.empty() || text.find(") Z ") != std::string::npos;
      },
      std::chrono::seconds(20)));
}

TEST_F(Isolation, NoRoomForRowsEndsTheRunWithThreeAndAResumeGoesOn) {
  const std::string in_folder =
      "cd " + (program_ / "") + " && XDG_CACHE_HOME=" + (program_ / "cache") + " ";
  ASSERT_EQ(program_.run("run c.yaml --out before").exit_code, 0);  // so that the raw copy is there
  // Two rows have 8 KiB; dash counts 512 bytes, other shells 1 KiB.
  const std::string limited = in_folder + "sh -c 'ulimit -f 8; exec " CVRBENCH_PROGRAM
                                          " run c.yaml --out o' >/dev/null 2>stderr";
  const int status = std::system(limited.c_str());
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 3) << status << program_.read("stderr");
  EXPECT_THAT(program_.read("stderr"), HasSubstr("cannot write: File too large"));
  const std::string rows = program_.read("o/rows.jsonl");
  EXPECT_TRUE(rows.empty() || rows.back() == '\n') << "a torn row";
  EXPECT_EQ(program_.run("run c.yaml --out o --resume").exit_code, 0);
  const std::string after = program_.read("o/rows.jsonl");
  EXPECT_TRUE(after.starts_with(rows));
  EXPECT_EQ(std::ranges::count(after, '\n'), 3);
}

TEST_F(Isolation, AFullScratchDiskCostsNoCell) {
  const std::string mounted =
      "cd " + (program_ / "") + " && XDG_CACHE_HOME=" + (program_ / "cache") +
      " unshare -rm sh -c 'mkdir -p o/scratch && mount -t tmpfs -o size=64k none o/scratch && "
      "head -c 60000 /dev/zero >o/scratch/full; exec " CVRBENCH_PROGRAM
      " run c.yaml --out o' >/dev/null 2>stderr";
  if (std::system("unshare -rm sh -c 'mount -t tmpfs none /mnt' 2>/dev/null") != 0)
    GTEST_SKIP() << "no right to mount a file system";
  EXPECT_EQ(std::system(mounted.c_str()), 0) << program_.read("stderr");
  EXPECT_EQ(std::ranges::count(program_.read("o/rows.jsonl"), '\n'), 3);
}

TEST_F(Isolation, ACacheThatCannotBeWrittenIsAReasonAndExitCodeThree) {
  const Outcome outcome = program_.run("run c.yaml --out o --cache c.yaml/cache");
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  const std::string rows = program_.read("o/rows.jsonl");
  EXPECT_THAT(rows, HasSubstr("c.yaml/cache: cannot write: the cache of raw copies (--cache DIR)"));
  EXPECT_EQ(std::ranges::count(rows, '\n'), 3);
  EXPECT_EQ(program_.run("run c.yaml --out o --resume --cache c.yaml/cache").exit_code, 3);
  EXPECT_EQ(program_.read("o/rows.jsonl"), rows) << "what the last row says is not said again";
  EXPECT_EQ(program_.run("run c.yaml --out o --resume").exit_code, 0);
}

TEST_F(Isolation, AChangedCopyIsMadeAnew) {
  ASSERT_EQ(program_.run("run c.yaml --out a").exit_code, 0);
  const json first = json::parse(
      program_.read("a/rows.jsonl").substr(0, program_.read("a/rows.jsonl").find('\n')));
  const std::string name =
      "cache/cvrbench/" + first["dataset"]["identity"].get<std::string>() + ".raw";
  const std::string voxels = program_.read(name);
  ASSERT_EQ(voxels.size(), first["dataset"]["bytes"].get<std::size_t>());
  std::string changed = voxels;
  changed[changed.size() / 2] ^= 1;
  program_.write(name, changed);
  ASSERT_EQ(program_.run("run c.yaml --out b").exit_code, 0);
  EXPECT_EQ(program_.read(name), voxels);
  const json second = json::parse(
      program_.read("b/rows.jsonl").substr(0, program_.read("b/rows.jsonl").find('\n')));
  EXPECT_EQ(second["dataset"]["content_hash"], first["dataset"]["content_hash"]);
  const std::string sidecar = program_.read(name + ".yaml");
  std::string turned = sidecar;
  turned.replace(turned.find("[16, 12, 9]"), 11, "[12, 16, 9]");
  program_.write(name + ".yaml", turned);
  ASSERT_EQ(program_.run("run c.yaml --out c").exit_code, 0);
  EXPECT_EQ(program_.read(name + ".yaml"), sidecar);
}

}  // namespace
}  // namespace cvr::cli_tests
