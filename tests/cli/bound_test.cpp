// A bound that a codec's parameters promise is kept, or the report, the row and the table say that
// it is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Bound : public testing::Test {
 protected:
  /// Floats up to 10^6, more than 2^-10 apart from what 30 bits for a block can say.
  void SetUp() override {
    std::string voxels;
    std::uint32_t state = 1;
    for (int i = 0; i < 16 * 16 * 16; ++i) {
      state = state * 1664525u + 1013904223u;
      const float value = 1e6f * static_cast<float>(state >> 8) / static_cast<float>(1 << 24);
      voxels.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    program_.write("v.raw", voxels);
    program_.write("v.raw.yaml", "extent: [16, 16, 16]\ntype: f32\nkind: scalars\n");
  }
  Program program_;
};

TEST_F(Bound, EncodeSaysThatItIsNotKept) {
  const std::string command =
      "encode v.raw -o v.cvr --codec zfp -p mode=accuracy -p tolerance_log2=-10";
  const Outcome text = program_.run(command);
  EXPECT_EQ(text.exit_code, 1);
  EXPECT_THAT(text.out, HasSubstr("bound kept: no"));
  const Outcome report = program_.run(command + " --json");
  EXPECT_EQ(report.exit_code, 1);
  const json found = json::parse(report.out);
  EXPECT_EQ(found["bound"], 0x1p-10);
  EXPECT_EQ(found["bound_kept"], false);
  EXPECT_GT(found["recorded_error"]["largest_error"].get<double>(), 0x1p-10);
  EXPECT_EQ(json::parse(program_.run("inspect v.cvr --json").out)["bound_kept"], false);
}

TEST_F(Bound, EncodeSaysThatItIsKept) {
  const Outcome text =
      program_.run("encode v.raw -o v.cvr --codec zfp -p mode=accuracy -p tolerance_log2=0");
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("bound kept: yes"));
  const json without = json::parse(program_.run("encode v.raw -o v.cvr --codec zfp --json").out);
  EXPECT_FALSE(without.contains("bound_kept")) << "a fixed rate promises no error";
}

TEST_F(Bound, RowsAndTablesTell) {
  program_.write("c.yaml", R"(title: T
rounds: 2
max_rounds: 2
matrix:
  - datasets: [{generator: turbulence, parameters: {bits: 32}, name: v, extent: [16, 16, 16]}]
    codecs: [{id: zfp, parameters: {mode: accuracy, tolerance_log2: [-100, -2]}}]
    stages: [encode]
tables:
  - {name: t, title: T, rows: [tolerance_log2], columns: [bound_kept]}
)");
  const Outcome run = program_.run("run c.yaml --out o");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string table = program_.read("o/tables/t.csv");
  EXPECT_THAT(table, HasSubstr("-100,no")) << table;
  EXPECT_THAT(table, HasSubstr("-2,yes")) << table;
}

}  // namespace
}  // namespace cvr::cli_tests
