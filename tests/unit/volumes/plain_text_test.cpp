#include "volumes/plain_text.hpp"

#include <gtest/gtest.h>

namespace cvr::volumes {
namespace {

TEST(PlainText, LeavesPlainTextAsItIs) {
  for (const char* text : {"", "a b", "Größe 3 µm", "\xF0\x9F\x9A\x80", "back\\slash"}) {
    EXPECT_EQ(printable(text), text);
    EXPECT_EQ(unprintable_at(text), std::nullopt);
  }
}

TEST(PlainText, ShowsControlCharacters) {
  EXPECT_EQ(printable("a\nb\r\tc\x1b[2J\x7f"), "a\\nb\\r\\tc\\x1b[2J\\x7f");
  EXPECT_EQ(printable(std::string_view("\0", 1)), "\\x00");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\u009b31m");                              // the one-byte form of ESC [
  EXPECT_EQ(printable("a\xE2\x80\xA8z"), "a\\u2028z");  // a line separator
  EXPECT_EQ(unprintable_at("ab\x1b"), 2u);
}

TEST(PlainText, ShowsBytesThatAreNoUtf8) {
  EXPECT_EQ(printable("\xff\xfe"), "\\xff\\xfe");
  EXPECT_EQ(printable("\xC0\x8A"), "\\xc0\\x8a");           // a line feed, overlong
  EXPECT_EQ(printable("\xED\xA0\x80"), "\\xed\\xa0\\x80");  // a surrogate
  EXPECT_EQ(printable("cut \xE2\x80"), "cut \\xe2\\x80");
}

}  // namespace
}  // namespace cvr::volumes
