// CSV as RFC 4180 has it, of tables and of rows.
#include "experiments/analysis/csv.hpp"

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
  const std::vector<Row> rows{
      {{"key", "a|b,c"}, {"size", {{"bytes", 5}, {"rate", nullptr}}}, {"list", {1, 2}}},
      {{"key", "d"}, {"ok", true}, {"size", {{"bytes", 0.5}}}}};
  EXPECT_EQ(to_csv(rows), "key,size.bytes,size.rate,ok\r\n\"a|b,c\",5,,\r\nd,0.5,,true\r\n");
  EXPECT_EQ(to_csv({}), "\r\n");
}

}  // namespace
}  // namespace cvr::experiments
