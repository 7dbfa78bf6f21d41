#include "experiments/results/rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "volumes/error.hpp"
#include "volumes/json_text.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments {

namespace {

constexpr std::size_t kQuoted = 40;  ///< bytes of a line that an error shows

/// What a JSON value lacks to be a row; empty: nothing. Deeper parts are their users' to check.
std::string missing_of(const Row& row) {
  if (!row.is_object()) return "a JSON object with cell, key and status";
  for (const char* key : {"cell", "key", "status"}) {
    if (!row.contains(key) || !row[key].is_string())
      return fmt::format("a JSON object with the text {}", key);
  }
  if (!is_status(row["status"].get_ref<const std::string&>()))
    return "a status of ok, failed, timeout, out-of-memory, unsupported or data-missing";
  for (const char* key : {"dataset", "codec", "provenance", "size", "time", "memory", "render",
                          "frames", "verification"}) {
    if (row.contains(key) && !row[key].is_object()) return fmt::format("an object as {}", key);
  }
  for (const char* key : {"reason", "stage"}) {
    if (row.contains(key) && !row[key].is_string()) return fmt::format("a text as {}", key);
  }
  return "";
}

}  // namespace

bool is_status(std::string_view text) {
  static constexpr std::array kAll{kOk,          kFailed,      kTimeout,
                                   kOutOfMemory, kUnsupported, kDataMissing};
  return std::ranges::find(kAll, text) != kAll.end();
}

double whole_over_part(const Row& row) {
  const Row& dataset = row.at("dataset");
  const double voxels = dataset.value("voxels", 1.0);
  return dataset.value("original_voxels", voxels) / voxels;
}

std::vector<Row> load_rows(const std::string& path) {
  std::vector<Row> rows;
  for_each_line(path, [&](std::size_t number, std::string_view line) {
    Row row = volumes::parse_json(line, path, number);
    if (const std::string missing = missing_of(row); !missing.empty()) {
      throw volumes::InputError(fmt::format("{}:{}: expected a row ({}), found '{}'", path, number,
                                            missing, volumes::printable(line.substr(0, kQuoted))));
    }
    rows.push_back(std::move(row));
  });
  return rows;
}

std::map<std::string, Row> latest_by(const std::vector<Row>& rows, const std::string& field) {
  std::map<std::string, Row> latest;
  for (const Row& row : rows) {
    if (row.contains(field) && row[field].is_string()) latest[row[field].get<std::string>()] = row;
  }
  return latest;
}

}  // namespace cvr::experiments
