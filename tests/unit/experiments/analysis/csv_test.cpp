// CSV as RFC 4180 has it, of tables and of rows.
#include "experiments/analysis/csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/tracking/export.hpp"

namespace cvr::experiments {
namespace {

TEST(Csv, FieldsAreEscapedAndLinesEndAsAsked) {
  const std::vector<std::vector<std::string>> lines{{"a", "b,c"}, {"", "d\"e\nf"}, {"g"}, {}};
  EXPECT_EQ(csv_text(lines), "a,\"b,c\"\n,\"d\"\"e\\nf\"\ng\n\n");
  EXPECT_EQ(csv_text(lines, "\r\n"), "a,\"b,c\"\r\n,\"d\"\"e\\nf\"\r\ng\r\n\r\n");
  EXPECT_EQ(csv_text({}), "");
}

TEST(Csv, RowsAreLinesAndTheirPlacesColumns) {
  std::vector<Result> rows(2);
  rows[0].key = std::string("a|b,c");
  rows[0].error.emplace().edge_voxels = 5;
  rows[0].access.emplace();
  rows[1].key = std::string("d");
  rows[1].error.emplace().exact = true;
  rows[1].size.emplace().rate = 0.5;
  const std::string text = to_csv(rows);
  EXPECT_THAT(text, testing::StartsWith("schema,cell,key,"));
  EXPECT_THAT(text, testing::HasSubstr(",error.edge_voxels,size.rate\r\n"));
  EXPECT_THAT(text, testing::HasSubstr("\r\n1,,\"a|b,c\","));
  EXPECT_THAT(text, testing::HasSubstr(",false,,,,,,5,\r\n1,,d,"));
  EXPECT_THAT(text, testing::EndsWith(",true,,,,,,,0.5\r\n"));
  EXPECT_EQ(to_csv({}), "\r\n");
}

}  // namespace
}  // namespace cvr::experiments
