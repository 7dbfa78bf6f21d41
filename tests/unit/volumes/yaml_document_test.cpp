#include "volumes/yaml_document.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volumes/error.hpp"

namespace cvr::volumes {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string refusal(const std::string& text) {
  try {
    load_yaml(text, "c.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(YamlDocument, TakesOneDocument) {
  EXPECT_EQ(load_yaml("---\na: 1\n", "d")["a"].Scalar(), "1");
  EXPECT_EQ(load_yaml("\xEF\xBB\xBF"
                      "a: 1\r\n",
                      "d")["a"]
                .Scalar(),
            "1")
      << "a byte order mark";
  EXPECT_EQ(load_yaml("a: 1\n...\n", "d")["a"].Scalar(), "1");
  EXPECT_TRUE(load_yaml("", "d").IsNull());
}

TEST(YamlDocument, RefusesASecondDocument) {
  EXPECT_THAT(
      refusal("a: 1\n---\na: 2\n"),
      AllOf(StartsWith("c.yaml:2"), HasSubstr("expected one YAML document, found a second one")));
  EXPECT_THAT(refusal("a: 1\n...\n---\n"), HasSubstr("found a second one"));
}

TEST(YamlDocument, AnchorsMayBeUsedAgainButNotWithinThemselves) {
  const YAML::Node node = load_yaml("a: &x [1, 2]\nb: *x\n", "d");
  EXPECT_EQ(node["b"][1].Scalar(), "2");
  EXPECT_THAT(refusal("a: &x [1, *x]\n"), HasSubstr("within what it names"));
}

TEST(YamlDocument, RefusesABombOfAliases) {
  std::string bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 20; ++i) {
    bomb += fmt::format("a{0}: &a{0} [", i);
    for (int k = 0; k < 10; ++k) bomb += fmt::format("{}*a{}", k == 0 ? "" : ", ", i - 1);
    bomb += "]\n";
  }
  EXPECT_THAT(refusal(bomb), HasSubstr("at most 1000000 values"));
}

TEST(YamlDocument, RefusesDeepNesting) {
  EXPECT_EQ(refusal(std::string(32, '[') + std::string(32, ']')), "accepted");
  EXPECT_THAT(refusal(std::string(33, '[') + std::string(33, ']')), HasSubstr("at most 32 levels"));
  EXPECT_NE(refusal(std::string(100000, '[')), "accepted");
  EXPECT_NE(refusal(std::string(100000, '{')), "accepted");
  std::string lists;
  for (int i = 0; i < 5000; ++i) lists += "- ";
  EXPECT_NE(refusal(lists), "accepted");
}

TEST(YamlDocument, RefusesTagsControlCharactersAndWhatIsNoYaml) {
  EXPECT_THAT(refusal("a: !!binary aGk=\n"), HasSubstr("expected a value without a tag"));
  EXPECT_THAT(refusal("a: 1\nb: \x1b[2J\n"),
              AllOf(StartsWith("c.yaml:2: "), HasSubstr("found '\\x1b'")));
  EXPECT_NE(refusal(std::string("a: \0b", 5)), "accepted");
  EXPECT_THAT(refusal("a:\n\tb: 1\n"), StartsWith("c.yaml:"));
  EXPECT_THAT(refusal("a: [1, 2\n"), StartsWith("c.yaml:"));
  EXPECT_THAT(refusal("a: *nowhere\n"), StartsWith("c.yaml:"));
}

}  // namespace
}  // namespace cvr::volumes
