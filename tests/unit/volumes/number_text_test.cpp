#include "volumes/number_text.hpp"

#include <gtest/gtest.h>

namespace cvr::volumes {
namespace {

TEST(NumberText, TakesWholeNumbers) {
  EXPECT_EQ(parse_unsigned("0"), 0u);
  EXPECT_EQ(parse_unsigned("10"), 10u);
  EXPECT_EQ(parse_unsigned("18446744073709551615"), UINT64_MAX);
  EXPECT_EQ(parse_signed("-10"), -10);
  EXPECT_EQ(parse_signed("-9223372036854775808"), INT64_MIN);
}

TEST(NumberText, RefusesWhatIsNoWholeNumber) {
  for (const char* text : {"", "-", "-1", "18446744073709551616", "010", "00", "1e3", " 5", "5 ",
                           "+5", "0x10", "5.0", "nan", "inf", "1,2", "5\n", "٣"})
    EXPECT_EQ(parse_unsigned(text), std::nullopt) << "'" << text << "'";
  for (const char* text : {"-010", "--1", "- 1", "9223372036854775808", "1e3"})
    EXPECT_EQ(parse_signed(text), std::nullopt) << text;
}

TEST(NumberText, TakesFiniteNumbersOnly) {
  EXPECT_EQ(parse_real("0.5"), 0.5);
  EXPECT_EQ(parse_real("-1e3"), -1000.0);
  EXPECT_EQ(parse_real("0"), 0.0);
  for (const char* text : {"", "nan", "inf", "-inf", "infinity", "1e999", "+1", " 1", "1 ", "0x1p3",
                           "010", "1,5", "1e", "1_000"})
    EXPECT_EQ(parse_real(text), std::nullopt) << "'" << text << "'";
}

TEST(NumberText, SaysWhatWasFound) {
  EXPECT_EQ(found_number("010"), "found '010' (write it without leading zeros)");
  EXPECT_EQ(found_number("+5"), "found '+5' (write it without a plus)");
  EXPECT_EQ(found_number(""), "found nothing");
  EXPECT_EQ(found_number("0x10"), "found '0x10'");
  EXPECT_EQ(found_number("1\n2"), "found '1\\n2'");
}

}  // namespace
}  // namespace cvr::volumes
