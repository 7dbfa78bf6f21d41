// generate, convert, encode, decode, validate, inspect, at, error, list: results, exit codes, one
// clear line for every mistake.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(program_.run("generate cells --size 40,24,33 --seed 7 -o v.raw").exit_code, 0);
    ASSERT_EQ(program_.run("encode v.raw -o v.cvr --codec csgvr-sb -p brick=16").exit_code, 0);
  }
  /// Exit code 2 and exactly one line on standard error that holds `text`.
  void expect_usage_error(const std::string& arguments, const std::string& text) {
    const Outcome outcome = program_.run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_THAT(outcome.err, HasSubstr(text)) << arguments;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << arguments << ": " << outcome.err;
    EXPECT_EQ(outcome.out, "") << arguments;
  }
  Program program_;
};

TEST_F(Files, GenerateIsDeterministicAndConvertKeepsEveryVoxel) {
  ASSERT_EQ(program_.run("generate cells --size 40,24,33 --seed 7 --threads 1 -o w.raw").exit_code,
            0);
  EXPECT_EQ(program_.read("v.raw"), program_.read("w.raw"));
  EXPECT_EQ(program_.read("v.raw").size(), 40u * 24 * 33 * 4);
  for (const std::string name : {"c.h5", "c.nrrd", "c.nii.gz"}) {
    ASSERT_EQ(program_.run("convert v.raw " + name).exit_code, 0) << name;
    const Outcome same = program_.run("error v.raw " + name + " --json");
    EXPECT_EQ(same.exit_code, 0) << name;
    EXPECT_EQ(json::parse(same.out)["voxels_compared"], 40 * 24 * 33) << name;
  }
  ASSERT_EQ(program_.run("generate cells --size 40,24,33 --seed 8 -o other.raw").exit_code, 0);
  EXPECT_EQ(program_.run("error v.raw other.raw").exit_code, 1);
}

TEST_F(Files, EncodeReportsSizesThatSum) {
  const Outcome outcome =
      program_.run("encode v.raw -o w.cvr --codec csgvr-sb -p brick=16 --threads 3 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  const std::string file = program_.read("w.cvr");
  EXPECT_EQ(report["bytes"], file.size());
  std::size_t sum = 0;
  for (const auto& [name, bytes] : report["breakdown"].items()) sum += bytes.get<std::size_t>();
  EXPECT_EQ(sum, file.size());
  const double original = 40.0 * 24 * 33 * 4;
  EXPECT_DOUBLE_EQ(report["rate"].get<double>(),
                   100.0 * static_cast<double>(file.size()) / original);
  EXPECT_DOUBLE_EQ(report["published_rate"].get<double>(),
                   100.0 * report["published_bytes"].get<double>() / original);
  EXPECT_LT(report["published_bytes"].get<std::size_t>(), file.size());
  EXPECT_GT(report["seconds"].get<double>(), 0);
  EXPECT_EQ(file, program_.read("v.cvr")) << "the bytes depend on the number of threads";
}

TEST_F(Files, InspectTellsWhatEncodeTold) {
  const json encoded =
      json::parse(program_.run("encode v.raw -o v.cvr --codec csgvr-sb -p brick=16 --json").out);
  const json inspected = json::parse(program_.run("inspect v.cvr --json").out);
  for (const char* key :
       {"codec", "parameters", "bytes", "published_bytes", "rate", "published_rate", "breakdown"}) {
    EXPECT_EQ(inspected.at(key), encoded.at(key)) << key;
  }
  EXPECT_EQ(inspected["extent"], json({40, 24, 33}));
  EXPECT_EQ(inspected["type"], "u32");
  EXPECT_THAT(program_.run("inspect v.raw").out, HasSubstr("extent: [40,24,33]"));
}

TEST_F(Files, AtAgreesWithTheOriginalAndWithCoarserLevels) {
  for (const std::string where : {"0 0 0", "39 23 32", "17 5 21"}) {
    const Outcome original = program_.run("at v.raw " + where);
    ASSERT_EQ(original.exit_code, 0);
    EXPECT_EQ(program_.run("at v.cvr " + where).out, original.out);
  }
  ASSERT_EQ(program_.run("decode v.cvr -o coarse.raw --lod 2").exit_code, 0);
  EXPECT_EQ(program_.run("at v.cvr 17 5 21 --lod 2").out, program_.run("at coarse.raw 4 1 5").out);
  // A codec without access to single voxels is decoded for it.
  ASSERT_EQ(program_.run("encode v.raw -o z.cvr --codec zstd").exit_code, 0);
  EXPECT_EQ(program_.run("at z.cvr 17 5 21").out, program_.run("at v.raw 17 5 21").out);
  expect_usage_error("at v.cvr 40 0 0", "since the extent is 40x24x33");
  expect_usage_error("at v.cvr 0 0 0 --lod 40", "--lod: expected 0..");
}

TEST_F(Files, DecodeAndErrorFindEveryVoxel) {
  ASSERT_EQ(program_.run("decode v.cvr -o d.nrrd --threads 2").exit_code, 0);
  EXPECT_EQ(program_.run("error v.raw d.nrrd").exit_code, 0);
  const json report = json::parse(program_.run("error v.raw v.cvr --json").out);
  EXPECT_EQ(report["mismatches"], 0);
  EXPECT_EQ(report["voxels_compared"], 40 * 24 * 33);
  std::string voxels = program_.read("v.raw");
  voxels[1234 * 4] = static_cast<char>(voxels[1234 * 4] ^ 1);
  program_.write("v.raw", voxels);
  const Outcome changed = program_.run("error v.raw v.cvr --json");
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_EQ(json::parse(changed.out)["mismatches"], 1);
}

TEST_F(Files, ScalarErrorsHaveKnownValues) {
  const std::string sidecar = "extent: [2, 2, 1]\ntype: u8\nkind: scalars\n";
  program_.write("a.raw", std::string("\x0a\x14\x1e\x28", 4));
  program_.write("b.raw", std::string("\x0a\x14\x1e\x2c", 4));
  program_.write("a.raw.yaml", sidecar);
  program_.write("b.raw.yaml", sidecar);
  const Outcome outcome = program_.run("error a.raw b.raw --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["mismatches"], 1);
  EXPECT_EQ(report["largest_error"], 4.0);
  EXPECT_EQ(report["mean_squared_error"], 4.0);
  EXPECT_NEAR(report["psnr_db"].get<double>(), 42.1102, 1e-4);  // 10 log10(255^2 / 4)
  const json same = json::parse(program_.run("error a.raw a.raw --json").out);
  EXPECT_TRUE(same["exact"].get<bool>());
  EXPECT_TRUE(same["psnr_db"].is_null());
}

TEST_F(Files, LossyFilesTellTheirErrorAndKeepIt) {
  ASSERT_EQ(program_.run("generate shells --size 40,24,33 --seed 1 -p bits=32 -o s.raw").exit_code,
            0);
  ASSERT_EQ(program_.run("encode s.raw -o s.cvr --codec zfp -p block_bits=200").exit_code, 0);
  const json inspected = json::parse(program_.run("inspect s.cvr --json").out);
  const Outcome outcome = program_.run("error s.raw s.cvr --threads 2 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;  // a lossy codec may differ
  const json report = json::parse(outcome.out);
  EXPECT_FALSE(report["exact"].get<bool>());
  for (const char* key : {"largest_error", "mean_squared_error"})
    EXPECT_NEAR(report[key].get<double>(), inspected["recorded_error"][key].get<double>(), 1e-12)
        << key;
  EXPECT_GT(report["edge_mean_squared_error"].get<double>(),
            report["mean_squared_error"].get<double>());
  EXPECT_GE(report["edge_voxels"].get<int>(), 40 * 24 * 33 / 20);
  EXPECT_EQ(report["non_finite_voxels"], 0);
  EXPECT_LE(report["relative_error"]["p50"].get<double>(),
            report["relative_error"]["p99"].get<double>());
  // Single voxels are scalars, not bits.
  ASSERT_EQ(program_.run("decode s.cvr -o d.raw").exit_code, 0);
  for (const std::string where : {"0 0 0", "20 12 2", "39 23 32"})
    EXPECT_EQ(program_.run("at s.cvr " + where).out, program_.run("at d.raw " + where).out)
        << where;
  expect_usage_error("encode v.raw -o x --codec zfp", "codec zfp ");
}

TEST_F(Files, DamagedFilesAreRefusedAtEveryByte) {
  const std::string whole = program_.read("v.cvr");
  EXPECT_EQ(program_.run("validate v.cvr").exit_code, 0);
  for (const std::size_t at :
       {std::size_t{0}, std::size_t{9}, std::size_t{13}, std::size_t{20}, std::size_t{50},
        std::size_t{100}, whole.size() / 2, whole.size() - 1}) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    program_.write("damaged.cvr", damaged);
    EXPECT_EQ(program_.run("validate damaged.cvr").exit_code, 1) << at;
    expect_usage_error("inspect damaged.cvr", "damaged.cvr: ");
    expect_usage_error("at damaged.cvr 1 1 1", "damaged.cvr: ");
    expect_usage_error("decode damaged.cvr -o d.raw", "damaged.cvr: ");
  }
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{7}, std::size_t{96}, whole.size() - 1}) {
    program_.write("short.cvr", whole.substr(0, size));
    EXPECT_EQ(program_.run("validate short.cvr").exit_code, 1) << size;
    expect_usage_error("inspect short.cvr", "short.cvr: ");
  }
}

TEST_F(Files, EveryMistakeIsOneLineAndExitCodeTwo) {
  expect_usage_error("", "expected one of the commands");
  expect_usage_error("encoed v.raw", "did you mean 'encode'?");
  expect_usage_error("encode v.raw --codec raw", "-o");
  expect_usage_error("encode none.raw -o x --codec raw", "none.raw");
  expect_usage_error("encode v.raw -o x --codec csgrv", "did you mean 'csgvr'?");
  expect_usage_error("encode v.raw -o x --codec csgvr -p brick=17",
                     "expected 16, 32, 64, found '17'");
  expect_usage_error("encode v.raw -o x --codec csgvr -p brik=16", "unknown parameter 'brik'");
  expect_usage_error("encode v.raw -o x --codec csgvr --threads 0", "--threads");
  expect_usage_error("generate cells --size 0,1,1 --seed 1 -o x.raw", "expected X,Y,Z");
  expect_usage_error("generate cells --size 1,1 --seed 1 -o x.raw", "expected X,Y,Z");
  expect_usage_error("generate celsl --size 1,1,1 --seed 1 -o x.raw", "celsl");
  expect_usage_error("generate cells --size 1,1,1 --seed 1 -p x -o x.raw", "expected NAME=NUMBER");
  expect_usage_error("generate cells --size 4,4,4 --seed 1 -o x.txt",
                     "expected the name of a volume");
  expect_usage_error("decode v.cvr -o d.raw --lod 9", "level of detail");
  expect_usage_error("decode none.cvr -o d.raw", "none.cvr");
  expect_usage_error("decode v.cvr -o d.txt", "expected the name of a volume");
  expect_usage_error("validate none.cvr", "none.cvr");
  expect_usage_error(
      "list things",
      "expected codecs, datasets, metrics, access-modes, stages, devices, config or rows");
  expect_usage_error("run none.yaml", "none.yaml");
  expect_usage_error("table none.yaml --results x", "none.yaml");
}

TEST_F(Files, ListsAreJsonArraysOfTheRegistries) {
  const json codecs = json::parse(program_.run("list codecs --json").out);
  ASSERT_TRUE(codecs.is_array());
  const auto found =
      std::ranges::find_if(codecs, [](const json& c) { return c["id"] == "csgvr-sb"; });
  ASSERT_NE(found, codecs.end());
  EXPECT_EQ((*found)["access"], "voxel");
  EXPECT_EQ((*found)["parameters"][0]["name"], "brick");
  EXPECT_EQ((*found)["parameters"][0]["default"], "32");
  for (const json& codec : codecs) EXPECT_NE(codec["family"], "") << codec["id"];
  EXPECT_GT(json::parse(program_.run("list datasets --json").out).size(), 30u);
  EXPECT_GT(json::parse(program_.run("list metrics --json").out).size(), 10u);
  EXPECT_EQ(program_.run("--help").exit_code, 0);
  EXPECT_THAT(program_.run("encode --help").out, HasSubstr("percent"));
}

TEST_F(Files, SeriesKeepTheirStepsThroughFilesOfAllKinds) {
  ASSERT_EQ(program_.run("generate moving --size 20,16,9 --seed 3 -p steps=3 -p largest=16 -o s.h5")
                .exit_code,
            0);
  ASSERT_EQ(
      program_.run("generate moving --size 20,16,9 --seed 3 -p time=2 -p largest=16 -o last.h5")
          .exit_code,
      0);
  EXPECT_EQ(program_.run("error last.h5 's.h5[2]'").exit_code, 0);
  EXPECT_EQ(json::parse(program_.run("error last.h5 's.h5[2]' --json").out)["mismatches"], 0);
  for (const std::string books : {"step", "shared"}) {
    const Outcome encoded =
        program_.run("encode s.h5 -o s.cvr --codec tvq -p rate=900 -p books=" + books + " --json");
    ASSERT_EQ(encoded.exit_code, 0) << encoded.err;
    const json inspected = json::parse(program_.run("inspect s.cvr --json").out);
    EXPECT_EQ(inspected["extent"], json({20, 16, 27}));
    EXPECT_EQ(inspected["time_steps"], 3);
    EXPECT_EQ(inspected["step_extent"], json({20, 16, 9}));
    EXPECT_EQ(inspected["parameters"]["books"], books);
    const json error = json::parse(program_.run("error s.h5 s.cvr --json").out);
    EXPECT_EQ(error["mean_squared_error"], inspected["recorded_error"]["mean_squared_error"]);
    EXPECT_EQ(error["time_steps"], 3);
    EXPECT_LE(error["worst_step_psnr_db"], error["psnr_db"]);
    for (const std::string name : {"d.nii.gz", "d.nrrd", "d.raw", "d.h5"}) {
      ASSERT_EQ(program_.run("decode s.cvr -o " + name).exit_code, 0) << name;
      EXPECT_EQ(json::parse(program_.run("inspect " + name + " --json").out)["time_steps"], 3)
          << name;
      EXPECT_EQ(
          json::parse(program_.run("error s.h5 " + name + " --json").out)["mean_squared_error"],
          error["mean_squared_error"])
          << name;
    }
    ASSERT_EQ(program_.run("validate s.cvr").exit_code, 0);
  }
  expect_usage_error("decode s.cvr -o d.precomputed", "no time axis");
  expect_usage_error("error last.h5 s.cvr", "20x16x27 u8 in 3 time steps");
  expect_usage_error("encode 's.h5[3]' -o x.cvr --codec tvq", "T from 0 to 2");
}

}  // namespace
}  // namespace cvr::cli_tests
