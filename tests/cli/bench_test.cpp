// bench: a volume file, no configuration; what it leaves can be measured again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

class Bench : public testing::Test {
 protected:
  /// Codecs of the ok rows of a folder, by stage; another status is a failure.
  std::map<std::string, std::set<std::string>> codecs_by_stage(const std::string& folder) {
    std::map<std::string, std::set<std::string>> codecs;
    std::istringstream in(program_.read(folder + "/rows.jsonl"));
    for (std::string line; std::getline(in, line);) {
      const json row = json::parse(line);
      if (row["status"] == "unsupported") continue;
      EXPECT_EQ(row["status"], "ok") << row["key"] << ": " << row["reason"];
      codecs[row["stage"]].insert(row["codec"]["id"]);
    }
    return codecs;
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(program_ / name); }
  Program program_;
};

TEST_F(Bench, MeasuresEveryCodecThatTakesTheFile) {
  ASSERT_EQ(program_.run("generate cells --size 40,36,33 --seed 3 -o 'my cells.v1.nrrd'").exit_code,
            0);
  const Outcome outcome =
      program_.run("bench 'my cells.v1.nrrd' --kind labels --minutes 20 --out o");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("| my-cells | csgvr-sb "), HasSubstr(" unsupported. Rows: "),
                    HasSubstr("Configuration: o/bench.yaml")));
  auto codecs = codecs_by_stage("o");
  for (const char* stage : {"encode", "decode", "random-access"}) {
    EXPECT_THAT(codecs[stage], AllOf(Contains("csgv-ctx"), Contains("csgvr-c"))) << stage;
    EXPECT_THAT(codecs[stage], Not(Contains("vq"))) << "lossy codecs take no labels";
  }
  EXPECT_THAT(codecs["decode"], Contains("zstd"));
  EXPECT_EQ(codecs["render"].size(), 1u) << "images of one codec";
  EXPECT_TRUE(exists("o/tables/bench_labels.csv"));
  EXPECT_TRUE(exists("o/report.html"));
  const Outcome again = program_.run("run o/bench.yaml --out p --only stage=encode");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(codecs_by_stage("p")["encode"], codecs["encode"]);
}

TEST_F(Bench, FilesOfOneNameAreToldApartAndScalarsHaveLossyCodecs) {
  ASSERT_EQ(program_.run("generate shells --size 24,20,16 --seed 3 -o s.nrrd").exit_code, 0);
  ASSERT_EQ(program_.run("generate cells --size 16,16,16 --seed 3 -o s.h5").exit_code, 0);
  const Outcome outcome = program_.run("bench s.nrrd s.h5 --minutes 20 --no-images --out o");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("| s       | tvq "), HasSubstr("| s-2     | csgvr-sb ")));
  EXPECT_THAT(codecs_by_stage("o")["decode"], AllOf(Contains("zfp"), Contains("csgvr")));
}

TEST_F(Bench, SaysWhatItTakesAFileForAndRefusesWhatItCannotRead) {
  program_.write("u.raw", std::string(64, 'x'));
  program_.write("u.raw.yaml", "extent: [4, 4, 4]\ntype: u8\n");
  const Outcome outcome = program_.run("bench u.raw --no-images --out o");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("u.raw: 4x4x4 u8 labels (if the voxels are measured values, "
                                     "say so with --kind scalars)\n"));
  EXPECT_EQ(program_.run("bench absent.nrrd --out p").exit_code, 2);
  EXPECT_EQ(program_.run("bench u.raw --kind labels --minutes 0 --out p").exit_code, 2);
  EXPECT_FALSE(exists("p"));
}

}  // namespace
}  // namespace cvr::cli_tests
