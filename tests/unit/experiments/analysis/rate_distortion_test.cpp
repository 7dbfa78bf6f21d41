// Fronts and BD-PSNR with values known by hand, and their tables.
#include "experiments/analysis/rate_distortion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "codecs/registry.hpp"
#include "experiments/analysis/table_formats.hpp"
#include "experiments/analysis/tables.hpp"
#include "tests/unit/experiments/results_of.hpp"
#include "tests/unit/experiments/stage.hpp"

namespace cvr::experiments {
namespace {

using Curve = std::vector<RatePoint>;

/// PSNR y at 10^x bits per voxel.
Curve curve(const std::vector<std::pair<double, double>>& points) {
  Curve made;
  for (const auto& [x, y] : points) made.push_back({std::pow(10, x), y});
  return made;
}

TEST(BdPsnr, OfACurveAndItselfIsNothing) {
  const Curve a = curve({{-1, 30}, {-0.5, 36}, {0, 41}, {0.5, 44}});
  const auto found = bd_psnr(a, a);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->db, 0);
  EXPECT_EQ(found->least_bits, a.front().bits_per_voxel);
  EXPECT_EQ(found->largest_bits, a.back().bits_per_voxel);
}

TEST(BdPsnr, OfAShiftIsTheShiftWhateverTheOrderOfThePoints) {
  const Curve a = curve({{-1, 30}, {-0.5, 36}, {0, 41}, {0.5, 44}, {0.9, 50}});
  Curve b;
  for (auto p = a.rbegin(); p != a.rend(); ++p) b.push_back({p->bits_per_voxel, p->psnr_db + 2.5});
  EXPECT_NEAR(bd_psnr(a, b).value().db, 2.5, 1e-12);
  EXPECT_NEAR(bd_psnr(b, a).value().db, -2.5, 1e-12);
}

// The cubics through (0, 0), (1, 1), (2, 4), (3, 9) have the slopes 0, 1.5, 3.75 and 6 there, so
// their integrals are 0.375, 2.3125 and 6.3125, together 9.
TEST(BdPsnr, IntegratesTheMonotoneCubics) {
  const Curve line = curve({{0, 0}, {1, 1}, {2, 2}, {3, 3}});
  const Curve square = curve({{0, 0}, {1, 1}, {2, 4}, {3, 9}});
  EXPECT_NEAR(bd_psnr(line, square).value().db, (9 - 4.5) / 3, 1e-12);
}

// From 1 to 2.5: 2.3125 and half a piece, 2.52734375.
TEST(BdPsnr, IntegratesOverTheCommonRatesAlone) {
  const Curve line = curve({{1, 1}, {1.5, 1.5}, {2, 2}, {2.5, 2.5}});
  const Curve square = curve({{0, 0}, {1, 1}, {2, 4}, {3, 9}});
  const auto found = bd_psnr(line, square);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->db, (2.3125 + 2.52734375 - 2.625) / 1.5, 1e-12);
  EXPECT_NEAR(found->least_bits, 10, 1e-12);
  EXPECT_NEAR(found->largest_bits, std::pow(10, 2.5), 1e-9);
}

TEST(BdPsnr, PointsOffTheFrontAndExactOnesAreLeftOut) {
  const Curve a = curve({{-1, 30}, {-0.5, 36}, {0, 41}, {0.5, 44}});
  Curve b = a;
  b.push_back({0.5, 12});
  b.push_back({7, std::numeric_limits<double>::infinity()});
  EXPECT_EQ(bd_psnr(a, b).value().db, 0);
}

TEST(BdPsnr, RefusesFewPointsAndRatesApart) {
  const Curve a = curve({{-1, 30}, {-0.5, 36}, {0, 41}, {0.5, 44}});
  const auto refusal = [&](const Curve& b) {
    const auto found = bd_psnr(a, b);
    return found ? std::string("accepted") : found.error().message;
  };
  EXPECT_EQ(refusal(curve({{-1, 30}, {0, 41}, {0.5, 44}})),
            "expected curves of 4 points or more, found one of 3");
  EXPECT_EQ(refusal(curve({{-1, 30}, {-0.5, 36}, {0, 35}, {0.5, 44}})),
            "expected curves of 4 points or more, found one of 3");
  EXPECT_EQ(refusal({}), "expected curves of 4 points or more, found one of 0");
  EXPECT_EQ(refusal(curve({{1, 30}, {2, 36}, {3, 41}, {4, 44}})),
            "expected rates in common, found 0.1 to 3.162 and 10 to 1e+04 bits/voxel");
}

TEST(ParetoFront, KeepsWhatNothingElseBeats) {
  const double exact = std::numeric_limits<double>::infinity();
  const Curve points{{1, 40}, {2, 39}, {0.5, 30}, {1, 41}, {1, 41}, {8, exact}, {9, exact}};
  EXPECT_THAT(pareto_front(points),
              testing::ElementsAre(false, false, true, true, true, true, false));
  EXPECT_TRUE(pareto_front({}).empty());
}

/// Lines of a sweep over the bits of zfp and one of bc4, on one volume.
class CurveTables : public testing::Test {
 protected:
  CurveTables() {
    auto dataset = std::make_shared<Dataset>();
    dataset->name = "blob";
    dataset->kind = volumes::VolumeKind::kScalars;
    dataset->extent = {10, 20, 30};
    const auto add = [&](const char* id, const std::vector<std::string>& parameters, double bits,
                         Row psnr) {
      const codecs::Codec* codec = codecs::find_codec(id);
      Cell cell{dataset,
                id,
                1,
                codecs::Parameters::parse(codec->parameters(), parameters).value(),
                stage("encode"),
                {"1", 1}};
      config_.cells.push_back(cell);
      Row row{{"cell", cell.row_key()}, {"key", cell.row_key()}, {"status", "ok"}, {"reason", ""}};
      row["size"]["bits_per_voxel"] = bits;
      row["verification"] = {{"voxels_compared", 6000}, {"mismatches", psnr.is_null() ? 0 : 100}};
      row["error"] = {{"psnr_db", psnr}, {"edge_psnr_db", psnr}, {"largest_error", 12.5}};
      rows_.push_back(row);
    };
    for (const int bits : {32, 64, 128, 256})
      add("zfp", {"block_bits=" + std::to_string(bits)}, bits / 64.0,
          30 + 6 * std::log2(bits / 32.0));
    for (const int bits : {33, 65, 129, 257})
      add("zfp", {"mode=accuracy", "block_bits=" + std::to_string(bits)}, (bits - 1) / 64.0,
          31 + 6 * std::log2((bits - 1) / 32.0));
    add("bc4", {}, 4, 40.0);
    add("zfp", {"block_bits=2048"}, 32, nullptr);
  }
  Config config_;
  std::vector<Row> rows_;
};

TEST_F(CurveTables, MarkTheFrontAndSayWhatIsExact) {
  TableSpec spec;
  spec.name = spec.title = "t";
  spec.rows = {"codec", "block_bits"};
  spec.columns = {"bits_per_voxel", "volume_psnr_db", "largest_error", "pareto"};
  EXPECT_EQ(render(make_table(spec, config_, results_of(rows_)), TableFormat::kCsv),
            "codec,block_bits,bits/voxel,PSNR dB,max error,front\n"
            "zfp,32,0.5000,30.00,12.5,\nzfp,64,1.0000,36.00,12.5,\nzfp,128,2.0000,42.00,12.5,\nzfp,"
            "256,4.0000,48.00,12.5,\n"
            "zfp,33,0.5000,31.00,12.5,*\nzfp,65,1.0000,37.00,12.5,*\nzfp,129,2.0000,43.00,12.5,*"
            "\nzfp,257,4.0000,49.00,12.5,*\n"
            "bc4,,4.0000,40.00,12.5,\n"
            "zfp,2048,32.0000,exact,12.5,*\n");
}

TEST_F(CurveTables, CompareCurvesWithTheReference) {
  TableSpec spec;
  spec.name = spec.title = "t";
  spec.rows = {"dataset", "codec", "mode"};
  spec.bd_reference = "zfp rate";
  const Table table = make_table(spec, config_, results_of(rows_));
  EXPECT_EQ(render(table, TableFormat::kCsv),
            "dataset,codec,mode,points,bits/voxel,PSNR dB,BD-PSNR dB,over\n"
            "blob,zfp,rate,5,0.500 .. 32.000,30.00 .. exact,+0.00,0.500 .. 4.000\n"
            "blob,zfp,accuracy,4,0.500 .. 4.000,31.00 .. 49.00,+1.00,0.500 .. 4.000\n"
            "blob,bc4,,1,4.000,40.00,,\n");
  const auto notes_of = [](const Table& made) {
    std::vector<std::string> notes;
    for (const Note& note : made.notes) notes.push_back(note.plain());
    return notes;
  };
  EXPECT_THAT(notes_of(table),
              testing::Contains("blob bc4: expected curves of 4 points or more, found one of 1."));
  EXPECT_EQ(table.columns[6].name, "bd_psnr_db");
  EXPECT_EQ(table.columns[6].unit, "dB");
  EXPECT_NEAR(table.lines[1].cells[6].number.value(), 1, 1e-9);
  EXPECT_EQ(table.lines[1].cells[7].number, 0.5);
  EXPECT_FALSE(table.lines[2].cells[6].number);
  spec.bd_reference = "tvq";
  const auto notes = notes_of(make_table(spec, config_, results_of(rows_)));
  EXPECT_EQ(std::ranges::count(notes, "blob has no curve 'tvq' to compare with."), 1);
}

}  // namespace
}  // namespace cvr::experiments
