// The tables of fields: rows that were read are written again, every field byte for byte, and what is
// no row is told by its place.
#include "experiments/results/result.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "experiments/results/json_lines.hpp"

namespace cvr::experiments {
namespace {

std::string error_of(const char* row) {
  try {
    from_json<Result>(Row::parse(row));
  } catch (const ShapeError& error) {
    return error.what();
  }
  return "";
}

std::string read(const std::string& path) {
  std::ifstream in(std::string(CVR_SOURCE_DIR) + path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> evidence(const std::string& run) {
  std::vector<std::string> lines;
  for_each_line(std::string(CVR_SOURCE_DIR) + "/results/evidence/" + run + "/rows.jsonl.zst",
                [&](std::size_t, std::string_view line) { lines.emplace_back(line); });
  EXPECT_FALSE(lines.empty()) << run;
  return lines;
}

/// Names and texts of the fields of a row, by name: rows of older revisions have another order.
std::map<std::string, std::string> fields_of(const Row& row) {
  std::map<std::string, std::string> fields;
  for (const auto& [name, value] : row.items()) fields[name] = value.dump();
  return fields;
}

TEST(Result, FieldsOfEveryKindOfRowAreWrittenAgainByteForByte) {
  std::vector<std::string> lines = lines_of(read("/tests/samples/rows.jsonl"));
  for (const char* run : {"table4-h200", "quick"}) {  // the first of an older revision
    for (std::string& line : evidence(run)) lines.push_back(std::move(line));
  }
  EXPECT_GT(lines.size(), 20u);
  for (const std::string& line : lines) {
    const Row row = Row::parse(line), again = to_json(from_json<Result>(row));
    EXPECT_EQ(fields_of(again), fields_of(row));
    EXPECT_EQ(to_json(from_json<Result>(again)).dump(), again.dump()) << "one order for all rows";
  }
}

TEST(Result, WhatIsMissingStaysAbsentAndWhatIsUnknownIsPassedOver) {
  const auto result = from_json<Result>(Row::parse(
      R"({"key": "k", "size": {"bytes": 5, "later": {}}, "error": {"psnr_db": null}, "new": 1})"));
  EXPECT_EQ(result.key, "k");
  EXPECT_EQ(result.size->bytes, 5u);
  EXPECT_FALSE(result.size->rate);
  EXPECT_FALSE(result.error->psnr_db);
  EXPECT_FALSE(result.time);
  EXPECT_EQ(to_json(result)["size"].dump(), R"({"bytes":5})");
}

TEST(Result, OtherTypesAreErrorsWithTheirPlace) {
  EXPECT_EQ(error_of("[]"), "an object as a row");
  EXPECT_EQ(error_of(R"({"time": null})"), "an object as time");
  EXPECT_EQ(error_of(R"({"size": {"bytes": "5"}})"), "an integer from 0 as size.bytes");
  EXPECT_EQ(error_of(R"({"size": {"bytes": -1}})"), "an integer from 0 as size.bytes");
  EXPECT_EQ(error_of(R"({"size": {"breakdown": {"index": 0.5}}})"),
            "an integer from 0 as size.breakdown.index");
  EXPECT_EQ(error_of(R"({"time": {"seconds": {"samples": [1, "2"]}}})"),
            "a number as time.seconds.samples[]");
  EXPECT_EQ(error_of(R"({"frames": {"ms": [[1], 2]}})"), "a list as frames.ms[]");
  EXPECT_EQ(error_of(R"({"held": {"cache_complete": 1}})"), "true or false as held.cache_complete");
}

TEST(Result, ThePartsOfAWorkerAreThoseOfARow) {
  const Row parts = Row::parse(R"({"size": {"bytes": 1}, "counters": {"b": 2, "a": 1}})");
  Row written = to_json(from_json<Parts>(parts));
  EXPECT_EQ(written["size"], parts["size"]);
  EXPECT_EQ(written["counters"].dump(), R"({"b":2,"a":1})");
}

}  // namespace
}  // namespace cvr::experiments
