#include "experiments/analysis/escaping.hpp"

#include <gtest/gtest.h>

namespace cvr::experiments {
namespace {

TEST(Escaping, MarkdownMarksAreWords) {
  EXPECT_EQ(escape_markdown("a|b"), "a\\|b");
  EXPECT_EQ(escape_markdown("a|b", false), "a|b");
  EXPECT_EQ(escape_markdown("`x` **y** ~z~ $w$"), "\\`x\\` \\*\\*y\\*\\* \\~z\\~ \\$w\\$");
  EXPECT_EQ(escape_markdown("<script> </b> <!-- 1 < 2"), "\\<script> \\</b> \\<!-- 1 < 2");
  EXPECT_EQ(escape_markdown("[a](b) [0.1, 0.2] &lt; a & b"), "[a\\](b) [0.1, 0.2] \\&lt; a & b");
  EXPECT_EQ(escape_markdown("cache_mib _em_"), "cache_mib \\_em\\_");
  EXPECT_EQ(escape_markdown("a\\|"), "a\\\\\\|");
  EXPECT_EQ(escape_markdown("a\n# b\x1b"), "a\\n# b\\x1b");
}

TEST(Escaping, LatexCommandsAreWords) {
  EXPECT_EQ(escape_latex("\\write18{x}"), "\\textbackslash{}write18\\{x\\}");
  EXPECT_EQ(escape_latex("50 % a_b #1 & $x$ ~ ^"),
            "50 \\% a\\_b \\#1 \\& \\$x\\$ \\textasciitilde{} \\textasciicircum{}");
  EXPECT_EQ(escape_latex("a\n\\input{x}"), "a\\textbackslash{}n\\textbackslash{}input\\{x\\}");
  EXPECT_EQ(escape_latex("<|>"), "\\textless{}\\textbar{}\\textgreater{}");
}

TEST(Escaping, CsvFieldsKeepTheirValue) {
  EXPECT_EQ(escape_csv("plain"), "plain");
  EXPECT_EQ(escape_csv("a,b"), "\"a,b\"");
  EXPECT_EQ(escape_csv("a\"b"), "\"a\"\"b\"");
  EXPECT_EQ(escape_csv(" a"), "\" a\"");
  EXPECT_EQ(escape_csv("=1+1"), "=1+1");
  EXPECT_EQ(escape_csv("-0.5"), "-0.5");
  EXPECT_EQ(escape_csv("a\r\nb"), "a\\r\\nb");
}

}  // namespace
}  // namespace cvr::experiments
