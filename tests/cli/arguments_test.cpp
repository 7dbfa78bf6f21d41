// Hostile and empty arguments of every command: exit code 2, one line on standard error that names
// the argument, nothing on standard output.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/cli/program.hpp"

namespace cvr::cli_tests {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr const char* kSmallConfig = R"(title: T
rounds: 1
matrix:
  - {datasets: [{generator: cells, extent: [8, 8, 8], name: blob}], codecs: [raw], stages: [encode]}
)";

class Arguments : public testing::Test {
 protected:
  void SetUp() override {
    program_.write("c.yaml", kSmallConfig);
    ASSERT_EQ(program_.run("generate cells --size 8,7,6 --seed 1 -o v.raw").exit_code, 0);
    ASSERT_EQ(program_.run("encode v.raw -o v.cvr --codec raw").exit_code, 0);
  }
  /// Standard error of a command that must be refused as usage.
  std::string refusal(const std::string& arguments) const {
    const Outcome outcome = program_.run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << "\n" << outcome.err;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << arguments << "\n"
                                                                           << outcome.err;
    EXPECT_THAT(outcome.err, StartsWith("cvrbench: ")) << arguments;
    return outcome.err;
  }
  Program program_;
};

/// What no option or position that asks for a whole number from 0 may be.
constexpr std::array kNoIntegers{"-1",    "18446744073709551616",
                                 "010",   "1e3",
                                 "' 5'",  "'5 '",
                                 "+5",    "0x10",
                                 "nan",   "inf",
                                 "1.5",   "five",
                                 "'1\n2'"};

TEST_F(Arguments, EveryIntegerIsStrict) {
  const std::vector<std::pair<std::string, std::string>> commands{
      {"generate cells --size 8,7,6 -o w.raw --seed=", "--seed"},
      {"generate cells --size 8,7,6 -o w.raw --seed=1 --threads=", "--threads"},
      {"encode v.raw -o w.cvr --codec raw --threads=", "--threads"},
      {"encode v.raw -o w.cvr --codec raw --bytes-per-voxel=", "--bytes-per-voxel"},
      {"decode v.cvr -o w.raw --lod=", "--lod"},
      {"decode v.cvr -o w.raw --threads=", "--threads"},
      {"validate v.cvr --threads=", "--threads"},
      {"at v.raw 0 0 0 --lod=", "--lod"},
      {"error v.raw v.cvr --threads=", "--threads"},
      {"render v.raw --scene cells -o w.png --frames=", "--frames"},
      {"render v.raw --scene cells -o w.png --samples=", "--samples"},
      {"render v.raw --scene cells -o w.png --brick=", "--brick"},
      {"render v.raw --scene cells -o w.png --cache-mib=", "--cache-mib"},
      {"render v.raw --scene cells -o w.png --threads=", "--threads"},
      {"aa c.yaml --repeats=", "--repeats"},
  };
  for (const auto& [command, option] : commands) {
    for (const char* value : kNoIntegers) {
      EXPECT_THAT(refusal(command + value),
                  AllOf(HasSubstr(option + ": "), HasSubstr("expected an integer in "),
                        HasSubstr("found ")))
          << value;
    }
    EXPECT_THAT(refusal(command + "''"), HasSubstr(option + ": 1 required")) << command;
  }
  EXPECT_THAT(refusal("generate cells --size 8,7,6 -o w.raw --seed -1"),
              HasSubstr("--seed: expected an integer in 0..18446744073709551615, found '-1'"));
  EXPECT_THAT(refusal("generate cells --size 8,7,6 -o w.raw --seed 010"),
              HasSubstr("(write it without leading zeros)"));
  for (const char* value : {"0", "4097", "100000"})
    EXPECT_THAT(refusal(std::string("validate v.cvr --threads ") + value), HasSubstr("1..4096"));
  EXPECT_EQ(
      program_.run("generate cells --size 8,7,6 --seed 18446744073709551615 -o w.raw").exit_code,
      0);
}

TEST_F(Arguments, CoordinatesAreStrictAndNamed) {
  for (const char* value :
       {"18446744073709551616", "010", "1e3", "' 5'", "+5", "0x1", "nan", "''", "1.0"}) {
    EXPECT_THAT(refusal(std::string("at v.raw ") + value + " 0 0"),
                HasSubstr("x: expected an integer"))
        << value;
    EXPECT_THAT(refusal(std::string("at v.raw 0 0 ") + value), HasSubstr("z: expected an integer"))
        << value;
  }
  for (const char* file : {"v.raw", "v.cvr"}) {
    const std::string at = std::string("at ") + file + " ";
    EXPECT_THAT(refusal(at + "-1 0 0"),
                HasSubstr("expected x in 0..7, since the extent is 8x7x6, found -1"));
    EXPECT_THAT(refusal(at + "0 7 0"),
                HasSubstr("expected y in 0..6, since the extent is 8x7x6, found 7"));
    EXPECT_THAT(refusal(at + "0 0 99999999999"), HasSubstr("expected z in 0..5"));
  }
}

TEST_F(Arguments, OtherNumbersAreStrict) {
  for (const char* value : {"nan", "inf", "-0.1", "1.1", "010", "0x1", "1e999", "half"})
    EXPECT_THAT(refusal(std::string("render v.raw --scene cells -o w.png --part=") + value),
                HasSubstr("--part: expected a number in 0..1, found"))
        << value;
  for (const char* value : {"8,7", "8,7,6,5", "0,7,6", "-8,7,6", "8,7,06", "8, 7,6", "8,7,6 ",
                            "8x7x6", ",,", "1048577,1,1", "1e1,1,1"})
    EXPECT_THAT(refusal(std::string("generate cells --seed 1 -o w.raw --size='") + value + "'"),
                HasSubstr("--size: expected X,Y,Z"))
        << value;
  EXPECT_THAT(refusal("generate cells --seed 1 -o w.raw --size 1048576,1048576,1048576"),
              HasSubstr("voxels in all"));
  for (const char* value : {"10", "10x", "x10", "010x10", "-1x5", "16385x1", "0x10", "'10 x 10'"})
    EXPECT_THAT(refusal(std::string("render v.raw --scene cells -o w.png --size=") + value),
                HasSubstr("--size: expected WIDTHxHEIGHT"))
        << value;
  EXPECT_THAT(refusal("history steps --store h --since yesterday"),
              HasSubstr("--since: expected a day YYYY-MM-DD"));
}

TEST_F(Arguments, ParametersAreStrictAndUnknownNamesHaveANeighbour) {
  const std::string generate = "generate shells --size 8,7,6 --seed 1 -o w.raw ";
  EXPECT_THAT(refusal(generate + "-p bist=8"),
              AllOf(HasSubstr("bist"), HasSubstr("did you mean 'bits'?")));
  for (const char* value : {"nan", "inf", "08", "+8", "' 8'", "", "0x8", "8.5", "1e999"})
    EXPECT_THAT(refusal(generate + "-p bits=" + value),
                AnyOf(HasSubstr("-p bits="), HasSubstr("shells: bits: expected")))
        << value;
  EXPECT_THAT(refusal(generate + "-p bits"), HasSubstr("expected NAME=NUMBER"));
  EXPECT_THAT(refusal(generate + "-p bits=8 -p bits=8"), HasSubstr("once"));
  EXPECT_THAT(refusal("generate shels --size 8,7,6 --seed 1 -o w.raw"),
              HasSubstr("did you mean 'shells'?"));
  const std::string encode = "encode v.raw -o w.cvr --codec ";
  EXPECT_THAT(refusal(encode + "csgvr -p birck=16"), HasSubstr("did you mean 'brick'?"));
  for (const char* value : {"016", "+16", "16.0", "1e1", "-16", "17", "", "18446744073709551632"})
    EXPECT_THAT(refusal(encode + "csgvr -p brick=" + value),
                HasSubstr("parameter 'brick': expected 16, 32, 64, found"))
        << value;
  EXPECT_THAT(refusal(encode + "csgvR"), HasSubstr("did you mean 'csgvr'?"));
  EXPECT_THAT(refusal("run c.yaml --out o --only codc=raw"), HasSubstr("did you mean 'codec'?"));
  EXPECT_THAT(refusal("run c.yaml --out o --only codec=rwa"),
              HasSubstr("--only codec=rwa keeps, found none of"));
  EXPECT_THAT(refusal("plan c.yaml --only codec=rwa"),
              HasSubstr("--only codec=rwa keeps, found none of"));
  for (const char* setting :
       {"rounds=-1", "rounds=1e3", "rounds=010", "rounds=", "seed=18446744073709551616",
        "timeout_s=nan", "rouds=3", "rounds", "'title=\"a\\nb\"'"})
    refusal(std::string("run c.yaml --out o --set ") + setting);
  EXPECT_THAT(refusal("run c.yaml --out o --set rounds=2 --set rounds=3"),
              HasSubstr("expected each key once"));
  EXPECT_THAT(refusal("run c.yaml --out o --set rounds=5 --set max_rounds=3"),
              HasSubstr("max_rounds of at least rounds (5), found 3"));
}

TEST_F(Arguments, VolumesTakeKindAxesAndExternalFilesEverywhere) {
  for (const char* command :
       {"encode v.raw -o w.cvr --codec raw", "convert v.raw w.nrrd", "inspect v.raw",
        "at v.raw 0 0 0", "error v.raw v.cvr", "render v.raw --scene cells -o w.png"}) {
    for (const char* axes : {"zy", "zyxx", "zyxq", "xyzct5", "ZYX"})
      EXPECT_THAT(refusal(std::string(command) + " --axes=" + axes),
                  HasSubstr("--axes: expected the letters x, y, z"))
          << command;
    EXPECT_THAT(
        refusal(std::string(command) + " --kind label"),
        HasSubstr("--kind: expected labels or scalars, found 'label' (did you mean 'labels'?)"));
    EXPECT_THAT(program_.run(std::string(command) + " --help").out,
                AllOf(HasSubstr("--axes"), HasSubstr("--allow-external"), HasSubstr("--kind")));
  }
  EXPECT_EQ(program_.run("inspect v.raw --kind labels --allow-external").exit_code, 0);
  for (const char* option : {"--kind labels", "--axes zyx", "--allow-external"})
    EXPECT_THAT(refusal(std::string("inspect v.cvr ") + option),
                HasSubstr("only with a volume, found an encoded file"));
}

TEST_F(Arguments, MissingUnknownAndEmptyOnesAreUsageErrors) {
  EXPECT_THAT(refusal(""), HasSubstr("expected one of the commands"));
  EXPECT_THAT(refusal("''"), HasSubstr("expected one of the commands"));
  EXPECT_THAT(refusal("enocde"), HasSubstr("did you mean 'encode'?"));
  for (const char* command :
       {"run",         "plan",     "list",           "generate",        "convert",
        "encode",      "decode",   "validate",       "inspect",         "at",
        "error",       "render",   "table",          "compare",         "ab",
        "aa",          "baseline", "baseline check", "baseline update", "history",
        "history add", "claims",   "report",         "export"}) {
    EXPECT_THAT(refusal(command), HasSubstr("--help")) << command;
    EXPECT_THAT(refusal(std::string(command) + " --no-such-option"), HasSubstr("--help"))
        << command;
    const Outcome help = program_.run(std::string(command) + " --help");
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_EQ(help.err, "") << command;
    if (std::string(command) != "generate") {
      EXPECT_THAT(help.out, HasSubstr("Exit codes: 0 ok; 1")) << command;
    }
  }
  for (const char* command : {"run ''",
                              "plan ''",
                              "list ''",
                              "generate '' --size 1,1,1 --seed 1 -o w.raw",
                              "generate cells --size 8,8,8 --seed 1 -o ''",
                              "convert '' w.raw",
                              "convert v.raw ''",
                              "encode '' -o w.cvr --codec raw",
                              "encode v.raw -o w.cvr --codec ''",
                              "decode '' -o w.raw",
                              "decode v.cvr -o ''",
                              "validate ''",
                              "inspect ''",
                              "at '' 0 0 0",
                              "error '' v.cvr",
                              "error v.raw ''",
                              "render '' --scene cells -o w.png",
                              "render v.raw --scene '' -o w.png",
                              "table '' --results o",
                              "table c.yaml --results ''",
                              "compare '' ''",
                              "ab '' '' c.yaml",
                              "aa ''",
                              "baseline check ''",
                              "history add ''",
                              "claims '' --results o",
                              "report --results '' -o page.html",
                              "export '' --format csv",
                              "export . --format xml",
                              "run . --out o",
                              "plan .",
                              "run missing.yaml",
                              "run v.raw",
                              "run /dev/null",
                              "list codecs surplus",
                              "list codec",
                              "validate .",
                              "inspect missing.h5"}) {
    refusal(command);
  }
}

TEST_F(Arguments, ConfigurationsAreOneStrictDocument) {
  const auto refused = [&](const std::string& text) {
    program_.write("bad.yaml", text);
    return refusal("run bad.yaml --out o");
  };
  EXPECT_THAT(refused(std::string(kSmallConfig) + "---\nrounds: 2\n"), HasSubstr("bad.yaml:5"));
  EXPECT_THAT(refused(std::string(kSmallConfig) + "---\nrounds: 2\n"),
              HasSubstr("expected one YAML document"));
  EXPECT_THAT(refused(""), HasSubstr("bad.yaml"));
  EXPECT_THAT(refused(std::string(kSmallConfig) + "rounds: 2\n"),
              HasSubstr("expected each key once"));
  EXPECT_THAT(refused("title: \"a\\nb\"\n" + std::string(kSmallConfig).substr(9)),
              HasSubstr("control characters"));
  EXPECT_THAT(refused(std::string(100000, '[')), HasSubstr("bad.yaml"));
  for (const char* value : {"010", "1e3", "+5", "0x10", "-1", "1.0", "18446744073709551616", "nan",
                            "[1]", "~", "\" 5\""})
    EXPECT_THAT(refused(std::string(kSmallConfig) + "seed: " + value + "\n"),
                HasSubstr("bad.yaml:5:7: expected an integer in 0..18446744073709551615, found"))
        << value;
  program_.write("bom.yaml", "\xEF\xBB\xBF" + std::string(kSmallConfig));
  EXPECT_EQ(program_.run("plan bom.yaml").exit_code, 0);
  EXPECT_THAT(refusal("run . --out o"), HasSubstr("found a folder"));
}

TEST_F(Arguments, ErrorsNeverCarryControlCharacters) {
  const auto is_clean = [](const std::string& text) {
    return std::ranges::none_of(text, [](char c) {
      return (static_cast<unsigned char>(c) < 0x20 && c != '\n') || c == 0x7F;
    });
  };
  for (const char* command : {"inspect $'a\\e[2Jb.h5'", "run $'a\\e]0;x\\ab.yaml'",
                              "list $'\\e[31m'", "encode v.raw -o w.cvr --codec $'r\\e[1m'",
                              "$'\\e[1m'", "generate $'\\e' --size 1,1,1 --seed 1 -o w.raw",
                              "validate $'v\\r.cvr'", "run c.yaml --out o --only $'\\e=1'"}) {
    program_.write("go.sh", std::string("exec " CVRBENCH_PROGRAM " ") + command + "\n");
    const Outcome found =
        program_.run("--version >/dev/null; bash go.sh");  // bash, since sh has no $'...'
    EXPECT_EQ(found.exit_code, 2) << command;
    EXPECT_TRUE(is_clean(found.err)) << command;
    EXPECT_EQ(found.out, "") << command;
  }
}

TEST_F(Arguments, RelativePathsInAFileAreRelativeToThatFile) {
  program_.write("deep/datasets/own.yaml",
                 "mine:\n  title: Mine\n  kind: labels\n  type: u32\n  extent: [8, 7, 6]\n  file: "
                 "../volumes/v.raw\n");
  program_.write("deep/volumes/v.raw", program_.read("v.raw"));
  program_.write("deep/volumes/v.raw.yaml", program_.read("v.raw.yaml"));
  program_.write("deep/own.yaml",
                 "rounds: 1\nmatrix:\n  - {datasets: [mine], codecs: [raw], stages: [encode]}\n");
  const Outcome plan = program_.run("plan deep/own.yaml");
  EXPECT_EQ(plan.exit_code, 0) << plan.err;
  EXPECT_THAT(plan.out, HasSubstr("2 to run"));
  program_.write("deep/datasets/own.yaml",
                 "mine:\n  title: Mine\n  kind: labels\n  type: u32\n  extent: [8, 7, 6]\n  file: "
                 "\"${HOME}/v.raw\"\n");
  EXPECT_THAT(refusal("plan deep/own.yaml"), HasSubstr("no other variable than ${CVRBENCH_DATA}"));
}

}  // namespace
}  // namespace cvr::cli_tests
