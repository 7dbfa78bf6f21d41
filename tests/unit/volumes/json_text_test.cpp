#include "volumes/json_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "volumes/error.hpp"

namespace cvr::volumes {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string refusal(std::string_view text, std::size_t line = 1) {
  try {
    parse_json(text, "rows.jsonl", line);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(JsonText, KeepsTheOrderOfKeys) {
  EXPECT_EQ(parse_json(R"({"b": 1, "a": [true, null, "x"]})", "d").dump(),
            R"({"b":1,"a":[true,null,"x"]})");
}

TEST(JsonText, KeepsLargeIntegersExactly) {
  EXPECT_EQ(parse_json("18446744073709551615", "d").get<std::uint64_t>(), UINT64_MAX);
}

TEST(JsonText, RefusesNestingBeyondTheLimit) {
  EXPECT_THAT(refusal(std::string(300000, '[')),
              AllOf(StartsWith("rows.jsonl:1:65:"), HasSubstr("at most 64 levels")));
  EXPECT_THAT(refusal("{\"a\":" + std::string(300000, '[') + std::string(300000, ']') + "}"),
              HasSubstr("at most 64 levels"));
  const std::string allowed = std::string(64, '[') + std::string(64, ']');
  EXPECT_EQ(parse_json(allowed, "d").dump(), allowed);
  EXPECT_THAT(refusal("[" + allowed + "]"), HasSubstr("at most 64 levels"));
}

TEST(JsonText, BracketsWithinTextAreNoNesting) {
  const std::string text = "\"" + std::string(1000, '[') + "\\\"" + std::string(1000, '{') + "\"";
  EXPECT_TRUE(parse_json(text, "d").is_string());
}

TEST(JsonText, RefusesKeysGivenTwice) {
  EXPECT_THAT(refusal(R"({"a": 1, "b": {"a": 2}, "a": 3})", 7),
              AllOf(StartsWith("rows.jsonl:7:"), HasSubstr("found \"a\" again")));
  EXPECT_THAT(refusal(R"({"a": 1, "a": 3})", 1), StartsWith("rows.jsonl:1: "));
  EXPECT_EQ(refusal(R"({"a": {"a": [{"a": 1}, {"a": 2}]}})"), "accepted");
}

TEST(JsonText, NamesLineAndColumn) {
  EXPECT_THAT(refusal("{\"a\": 1,\n \"b\": ?}"),
              AllOf(StartsWith("rows.jsonl:2:7:"), HasSubstr("expected JSON, found")));
  EXPECT_THAT(refusal("{} {}", 12), StartsWith("rows.jsonl:12:4:"));
  EXPECT_THAT(refusal(""), HasSubstr("expected JSON"));
  EXPECT_THAT(refusal("{\"cell\": \"to"), HasSubstr("expected JSON"));
}

TEST(JsonText, RefusesNumbersAndTextThatAreNone) {
  for (const char* text :
       {"NaN", "inf", "01", "+1", ".5", "1e999", "'a'", "\"\x01\"", "\"\xff\"", "[1,]", "// x\n1"})
    EXPECT_NE(refusal(text), "accepted") << text;
}

TEST(JsonText, AFolderIsNoFile) {
  try {
    read_json_file("/");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(StartsWith("/: "), HasSubstr("folder")));
  }
  EXPECT_THROW(read_json_file("/absent.json"), InputError);
}

}  // namespace
}  // namespace cvr::volumes
