#include "experiments/results/rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "volumes/error.hpp"
#include "volumes/json_text.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments {

namespace {

constexpr std::size_t kQuoted = 40;  ///< bytes of a line that an error shows

/// Throws ShapeError.
Result result_of(const Row& row) {
  if (!row.is_object()) throw ShapeError("a JSON object with cell, key and status");
  for (const char* key : {"cell", "key", "status"}) {
    if (!row.contains(key) || !row[key].is_string())
      throw ShapeError(fmt::format("a JSON object with the text {}", key));
  }
  Result result = from_json<Result>(row);
  if (!is_status(result.status))
    throw ShapeError("a status of ok, failed, timeout, out-of-memory, unsupported or data-missing");
  return result;
}

}  // namespace

bool is_status(std::string_view text) {
  static constexpr std::array kAll{kOk,          kFailed,      kTimeout,
                                   kOutOfMemory, kUnsupported, kDataMissing};
  return std::ranges::find(kAll, text) != kAll.end();
}

double whole_over_part(const Result& result) {
  const auto voxels = static_cast<double>(result.dataset.voxels.value_or(1));
  const Count& original = result.dataset.original_voxels;
  return (original ? static_cast<double>(*original) : voxels) / voxels;
}

std::vector<Result> load_rows(const std::string& given) {
  std::error_code error;
  const std::string packed = given + std::string(kCompressedEnding);
  const std::string& path =
      !std::filesystem::exists(given, error) && std::filesystem::exists(packed, error) ? packed
                                                                                       : given;
  std::vector<Result> results;
  for_each_line(path, [&](std::size_t number, std::string_view line) {
    try {
      results.push_back(result_of(volumes::parse_json(line, path, number)));
    } catch (const ShapeError& error) {
      throw volumes::InputError(fmt::format("{}:{}: expected a row ({}), found '{}'", path, number,
                                            error.what(),
                                            volumes::printable(line.substr(0, kQuoted))));
    }
  });
  return results;
}

std::map<std::string, Result> latest_by(const std::vector<Result>& results,
                                        std::string Result::*field) {
  std::map<std::string, Result> latest;
  for (const Result& result : results) latest[result.*field] = result;
  return latest;
}

}  // namespace cvr::experiments
