// pack and verify: a run becomes a pack that verifies; what is changed in a pack is found.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kConfig = R"(title: T
rounds: 1
max_rounds: 1
lods: [0]
matrix:
  - datasets: [{generator: cells, extent: [16, 16, 16], name: blob}]
    codecs: [zstd, csgvr-sb]
    stages: [encode, decode, random-access]
tables:
  - {name: t, title: Sizes of a blob, rows: [dataset, codec], columns: [rate, exact, status]}
)";

class Pack : public testing::Test {
 protected:
  void SetUp() override {
    program_.write("c.yaml", kConfig);
    const Outcome measured = program_.run("run c.yaml --out o");
    ASSERT_EQ(measured.exit_code, 0) << measured.err;
  }
  /// A pack made anew, with hashes made anew, after rows.jsonl was changed by sed.
  Outcome packed_after(const std::string& change) {
    const std::string rows = program_ / "o/rows.jsonl";
    EXPECT_EQ(std::system(("sed -i '" + change + "' " + rows).c_str()), 0);
    return program_.run("pack o -o changed.zip");
  }
  Program program_;
};

TEST_F(Pack, OfARunVerifies) {
  const Outcome packed = program_.run("pack o -o r.zip --title 'Of a blob' --creator 'A. Name'");
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const Outcome again = program_.run("pack o -o s.zip --title 'Of a blob' --creator 'A. Name'");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(program_.read("r.zip"), program_.read("s.zip"));
  fs::remove_all(program_ / "o");
  fs::remove(program_ / "c.yaml");
  const Outcome verified = program_.run("verify r.zip --all");
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  EXPECT_THAT(verified.out, HasSubstr("files agree."));
  EXPECT_THAT(verified.out, HasSubstr("| blob 16x16x16 csgvr-sb brick=32 1 encode | "));
  EXPECT_THAT(verified.out, HasSubstr("All exact figures of "));
  const Outcome one = program_.run("verify r.zip --cells 1 --seed 7 --json");
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_THAT(one.out, HasSubstr("\"agrees\": true"));
  EXPECT_THAT(one.out, HasSubstr("\"seed\": 7"));
}

/// Another machine, and times of it: the exact figures must agree all the same.
TEST_F(Pack, OfAnotherMachineVerifies) {
  const Outcome packed = packed_after(
      R"(s/"machine":"[0-9a-f]*"/"machine":"0123456789abcdef"/; s/"cores":[0-9]*/"cores":64/; )"
      R"(s/"cpu":"[^"]*"/"cpu":"Another"/)");
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const Outcome verified = program_.run("verify changed.zip --all");
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
}

TEST_F(Pack, AFigureThatIsNotOfTheProgramIsFoundByMeasuring) {
  const Outcome packed = packed_after(R"(s/"published_bytes":[0-9]*/"published_bytes":1/)");
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const Outcome verified = program_.run("verify changed.zip --all");
  EXPECT_EQ(verified.exit_code, 1);
  EXPECT_THAT(verified.out, HasSubstr("size.published_bytes: 1.0 there, "));
  EXPECT_THAT(verified.out, HasSubstr("Exact figures of "));
}

TEST_F(Pack, WhatIsNoneIsRefused) {
  EXPECT_EQ(program_.run("pack none -o r.zip").exit_code, 2);
  EXPECT_EQ(program_.run("pack o -o o/rows.jsonl").exit_code, 2);
  fs::create_directories(program_ / "empty");
  const Outcome empty = program_.run("pack empty -o r.zip");
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_THAT(empty.err, HasSubstr("expected rows.jsonl with rows, found none"));
  EXPECT_FALSE(fs::exists(program_ / "r.zip"));
  EXPECT_EQ(program_.run("verify none.zip").exit_code, 2);
  program_.write("no.zip", "PK no zip at all");
  const Outcome none = program_.run("verify no.zip");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("no.zip: expected a whole zip"));
  const Outcome failed = packed_after(R"(s/"status":"ok"/"status":"failed"/)");
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(failed.err, HasSubstr("nothing to pack"));
}

}  // namespace
}  // namespace cvr::cli_tests
