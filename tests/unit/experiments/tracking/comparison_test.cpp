// What is said of two sets of rows: exact figures, counted work, times, and how often times are
// wronged.
#include "experiments/tracking/comparison.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "experiments/tracking/noise_measurement.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

/// A shared machine: times above the least by a heavy tail, a slow drift, and now and then a burst.
class NoisyMachine {
 public:
  explicit NoisyMachine(std::uint64_t seed) : random_(seed) {}
  double time(double seconds) {
    drift_ = 0.9 * drift_ + 0.02 * normal_(random_);
    const double burst = random_() % 12 == 0 ? 1.6 : 1;
    return seconds * std::exp(drift_ + 0.03 * std::abs(normal_(random_))) * burst;
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  double drift_ = 0;
};

struct Measured {
  std::vector<double> base, fresh;
};
Measured side_by_side(NoisyMachine& machine, double factor, int rounds) {
  Measured m;
  for (int i = 0; i < rounds; ++i) {
    m.base.push_back(machine.time(0.01));
    m.fresh.push_back(machine.time(0.01 * factor));
  }
  return m;
}

TEST(JudgeTimes, WrongsABuildAgainstItselfAtMostOnceInTwoHundred) {
  for (const bool paired : {true, false}) {
    NoisyMachine machine(11);
    int wrong = 0;
    for (int i = 0; i < 200; ++i) {
      const Measured m = side_by_side(machine, 1, 15);
      const Outcome outcome = judge_times(m.base, m.fresh, 0.05, paired).outcome;
      wrong += outcome == Outcome::kFaster || outcome == Outcome::kSlower;
    }
    EXPECT_LE(wrong, 1) << paired;
  }
}

TEST(JudgeTimes, FindsADecoderThatIsSlower) {
  for (const auto& [factor, least] : {std::pair{1.2, 18}, {1.5, 20}}) {
    NoisyMachine machine(5);
    int slower = 0, faster = 0;
    for (int i = 0; i < 20; ++i) {
      const Measured m = side_by_side(machine, factor, 31);
      slower += judge_times(m.base, m.fresh, 0.05, true).outcome == Outcome::kSlower;
      faster += judge_times(m.fresh, m.base, 0.05, true).outcome == Outcome::kFaster;
    }
    EXPECT_GE(slower, least) << factor;
    EXPECT_GE(faster, least) << factor;
  }
}

TEST(JudgeTimes, SaysWhyItDoesNotDecide) {
  const std::vector<double> three{1, 1.01, 1.02}, slow{2, 2.01, 2.02};
  const TimeVerdict few = judge_times(three, slow, 0.05, false);
  EXPECT_EQ(few.outcome, Outcome::kUndecided);
  EXPECT_NE(few.reason.find("more rounds"), std::string::npos) << few.reason;
  const std::vector<double> steady{1, 1.001, 1.002, 1.003, 1.004, 1.005, 1.006, 1.007, 1.008};
  EXPECT_EQ(judge_times(steady, steady, 0.05, false).outcome, Outcome::kSame);
  EXPECT_EQ(judge_times(steady, steady, 0.05, true).outcome, Outcome::kSame);
  // One sample per side, all equal, one outlier.
  EXPECT_EQ(judge_times(std::vector{1.0}, std::vector{9.0}, 0.05, false).outcome,
            Outcome::kUndecided);
  EXPECT_EQ(
      judge_times(std::vector<double>(12, 1.0), std::vector<double>(12, 1.0), 0.05, true).outcome,
      Outcome::kSame);
  std::vector<double> outlier = steady;
  outlier.back() = 50;
  EXPECT_EQ(judge_times(steady, outlier, 0.05, false).outcome, Outcome::kSame);
}

Result result_of(const std::string& key, std::uint64_t bytes, const std::vector<double>& seconds) {
  Result result;
  result.cell = key + "-id";
  result.key = key;
  result.status = "ok";
  result.codec.id = "csgvr";
  result.stage = "decode";
  result.provenance.machine = "m";
  result.size.emplace().bytes = bytes;
  result.size->checksums.emplace()["index"] = "00ff";
  result.verification.emplace().mismatches = 0;
  result.counters = {{"cells_decoded", 1000}};
  result.time.emplace().seconds.emplace().samples = seconds;
  return result;
}

const ComparedQuantity& find(const CompareReport& report, const std::string& quantity) {
  for (const ComparedQuantity& c : report.comparisons) {
    if (c.base.name == quantity) return c;
  }
  throw std::runtime_error("no " + quantity);
}

TEST(CompareRows, TellsExactCountedAndTimedApart) {
  const std::vector<double> times{1, 1.01, 1.02, 1.03, 1.04, 1.05, 1.06, 1.07, 1.08};
  std::vector<double> slow = times;
  for (double& t : slow) t *= 1.5;
  const Result base = result_of("a", 100, times);
  Result fresh = result_of("a", 101, slow);
  (*fresh.size->checksums)["index"] = "00fe";
  fresh.counters = {{"cells_decoded", 1200}};
  const CompareReport report = compare_rows({base}, {fresh}, {});
  EXPECT_EQ(find(report, "size.bytes").outcome, Outcome::kDiffers);
  EXPECT_EQ(find(report, "size.checksums.index").outcome, Outcome::kDiffers);
  EXPECT_EQ(find(report, "verification.mismatches").outcome, Outcome::kSame);
  EXPECT_EQ(find(report, "counters.cells_decoded").outcome, Outcome::kMore);
  EXPECT_EQ(find(report, "decode").outcome, Outcome::kSlower);
  EXPECT_NEAR(find(report, "decode").ratio, 1.5, 1e-9);
  EXPECT_TRUE(report.differs());
  EXPECT_TRUE(report.slower());
  ASSERT_EQ(report.remarks.size(), 1u);  // the floor is assumed
  const auto summary = summarise(report);
  ASSERT_EQ(summary.size(), 1u);
  EXPECT_EQ(summary[0].codec, "csgvr");
  EXPECT_EQ(summary[0].mode, "decode");
  EXPECT_NEAR(summary[0].time_ratio, 1.5, 1e-9);
  EXPECT_NEAR(summary[0].size_ratio, 1.01, 1e-9);
  const std::string text = describe(report, false);
  EXPECT_NE(text.find("**slower** decode"), std::string::npos) << text;
  EXPECT_EQ(text.find("**same**"), std::string::npos) << text;
  EXPECT_NE(describe(report, true).find("**same** verification.mismatches"), std::string::npos);
}

TEST(CompareRows, ComparesTimesOfOneMachineAndCellAlone) {
  const std::vector<double> times(9, 1.0), slow(9, 2.0);
  const Result base = result_of("a", 100, times);
  Result elsewhere = result_of("a", 100, slow), changed = result_of("a", 100, slow);
  elsewhere.provenance.machine = "other";
  changed.cell = "of another codec version";
  EXPECT_EQ(find(compare_rows({base}, {elsewhere}, {}), "decode").outcome, Outcome::kNotCompared);
  EXPECT_EQ(find(compare_rows({base}, {changed}, {}), "decode").outcome, Outcome::kNotCompared);
  EXPECT_EQ(find(compare_rows({base}, {changed}, {}), "size.bytes").outcome, Outcome::kSame);
}

TEST(CompareRows, NamesWhatFailsAndWhatIsMissing) {
  const std::vector<double> times(9, 1.0);
  Result failed = result_of("a", 100, times);
  failed.status = "failed";
  failed.reason = "3 voxels differ";
  const CompareReport report = compare_rows({result_of("a", 100, times), result_of("b", 1, times)},
                                            {failed, result_of("c", 1, times)}, {});
  EXPECT_EQ(find(report, "status").outcome, Outcome::kDiffers);
  EXPECT_NE(find(report, "status").reason.find("3 voxels differ"), std::string::npos);
  EXPECT_EQ(report.only_in_base, std::vector<std::string>{"b"});
  EXPECT_EQ(report.only_in_new, std::vector<std::string>{"c"});
}

TEST(NoiseFloors, AreWhatABuildDiffersFromItselfBy) {
  const auto path =
      (std::filesystem::temp_directory_path() / "cvrbench-noise-test" / "noise.json").string();
  std::filesystem::remove_all(std::filesystem::path(path).parent_path());
  EXPECT_FALSE(load_floors(path, "m", Arrangement::kApart).knows("decode"));
  EXPECT_EQ(load_floors(path, "m", Arrangement::kApart).of("decode"), kAssumedFloor);
  std::vector<double> times(9, 1.0), later(9, 1.12);
  const Row measured =
      measure_floors({{{result_of("a", 1, times)}, {result_of("a", 1, later)}}}, false);
  EXPECT_NEAR(measured["decode"]["floor"].get<double>(), 0.24, 1e-9);
  EXPECT_EQ(measured["decode"]["cells"], 1);
  Provenance provenance;
  provenance.machine = "m";
  store_floors(path, provenance, "config.yaml", Arrangement::kApart, measured);
  EXPECT_NEAR(load_floors(path, "m", Arrangement::kApart).of("decode"), 0.24, 1e-9);
  EXPECT_NEAR(measure_floors({{{result_of("a", 1, times)}, {result_of("a", 1, times)}}},
                             true)["decode"]["floor"]
                  .get<double>(),
              0.05, 1e-9);
  EXPECT_FALSE(load_floors(path, "m", Arrangement::kInterleaved).knows("decode"));
  EXPECT_FALSE(load_floors(path, "other", Arrangement::kApart).knows("decode"));
  std::filesystem::remove_all(std::filesystem::path(path).parent_path());
}

}  // namespace
}  // namespace cvr::experiments
