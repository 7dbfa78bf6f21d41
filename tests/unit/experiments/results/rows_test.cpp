#include "experiments/results/rows.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/samples/scratch_folder.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {
namespace {

Result make_result(const std::string& cell, const std::string& status) {
  Result result;
  result.cell = cell;
  result.key = "k" + cell;
  result.status = status;
  return result;
}

std::string line_of(const std::string& cell) { return to_json(make_result(cell, "ok")).dump(); }

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Rows, RoundTripAndTheLastRowOfACellCounts) {
  const ScratchFolder folder;
  const std::string path = folder / "rows.jsonl";
  EXPECT_TRUE(load_rows(path).empty());
  {
    RowWriter writer(path);
    writer.append(make_result("1", "failed"));
    writer.append(make_result("2", "ok"));
    writer.append(make_result("1", "ok"));
  }
  const auto rows = load_rows(path);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(to_json(rows[1]), to_json(make_result("2", "ok")));
  EXPECT_EQ(latest_by(rows, &Result::cell).at("1").status, "ok");
}

TEST(Rows, TornLastLineIsPassedOverAndCutOff) {
  const ScratchFolder folder;
  const std::string path = folder / "rows.jsonl";
  RowWriter(path).append(make_result("1", "ok"));
  const std::string whole = text_of(path);
  std::ofstream(path, std::ios::app) << R"({"cell": "2", "ke)";
  EXPECT_EQ(load_rows(path).size(), 1u);
  RowWriter(path).append(make_result("3", "ok"));
  EXPECT_THAT(text_of(path), testing::StartsWith(whole));
  const auto rows = load_rows(path);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[1].cell, "3");
}

TEST(Rows, ABrokenLineInTheMiddleIsAnErrorWithItsLine) {
  const ScratchFolder folder;
  const std::string path =
      folder.write("rows.jsonl", line_of("1") + "\nnonsense\n" + line_of("2") + "\n");
  try {
    load_rows(path);
    FAIL() << "no error";
  } catch (const volumes::InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("rows.jsonl:2:2: expected JSON"));
  }
}

TEST(Rows, WhatIsNoRowIsAnErrorWithItsPlace) {
  const ScratchFolder folder;
  const auto error = [&](const std::string& line) -> std::string {
    const std::string path = folder.write("rows.jsonl", line_of("1") + "\n" + line + "\n");
    try {
      load_rows(path);
    } catch (const volumes::InputError& failure) {
      return failure.what();
    }
    return "no error";
  };
  EXPECT_EQ(error(line_of("1")), "no error") << "a cell that was measured again";
  for (const char* line : {"[]", "{}", R"({"cell": 1, "key": "k", "status": "ok"})",
                           R"({"cell": "1", "key": "k", "status": "fine"})",
                           R"({"cell": "1", "key": "k", "status": "ok", "dataset": []})",
                           R"({"cell": "1", "key": "k", "status": "ok", "reason": 5})"}) {
    EXPECT_THAT(error(line), testing::HasSubstr("rows.jsonl:2: expected a row")) << line;
  }
  EXPECT_THAT(error(R"({"cell": "1", "key": "k", "status": "ok", "status": "failed"})"),
              testing::HasSubstr("rows.jsonl:2: expected each key once"));
  const std::string deep = std::string(300000, '[') + std::string(300000, ']');
  EXPECT_THAT(error(R"({"cell": "1", "key": "k", "status": "ok", "x": )" + deep + "}"),
              testing::HasSubstr("at most 64 levels"));
  EXPECT_THAT(error(std::string(300000, '[')), testing::HasSubstr("at most 64 levels"));
}

TEST(Rows, ASecondWriterIsRefused) {
  const ScratchFolder folder;
  const std::string path = folder / "rows.jsonl";
  const RowWriter first(path);
  EXPECT_THROW(RowWriter{path}, volumes::InputError);
}

}  // namespace
}  // namespace cvr::experiments
