// Rows: the outcome of one cell each, as JSON lines in OUT/rows.jsonl (results/schema/row.schema.json says
// what a row holds).
//
// A row is appended with one write and an fsync, so a kill can tear the last line at most. Loading passes
// over a torn last line and appending cuts it off. A cell that was done again has several rows; the last one
// counts.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace cvr::experiments {

using Row = nlohmann::ordered_json;

inline constexpr std::string_view kOk = "ok";
inline constexpr std::string_view kFailed = "failed";
inline constexpr std::string_view kTimeout = "timeout";
inline constexpr std::string_view kOutOfMemory = "out-of-memory";
inline constexpr std::string_view kUnsupported = "unsupported";
inline constexpr std::string_view kDataMissing = "data-missing";

/// Voxels of the original over those of the volume that the row is about: above 1 where a part or a smaller volume stands for it.
double whole_over_part(const Row& row);

/// All whole rows of a file, none if it does not exist. Throws InputError (FILE:LINE) for a line in the
/// middle that is no row.
std::vector<Row> load_rows(const std::string& path);

/// The last row of each value of a text field, for instance "cell" or "key".
std::map<std::string, Row> latest_by(const std::vector<Row>& rows, const std::string& field);

class RowWriter {
 public:
  /// Opens for appending; makes the file; cuts a torn last line off. Throws std::system_error, and InputError
  /// while another run writes to the file.
  explicit RowWriter(const std::string& path);
  ~RowWriter();
  RowWriter(const RowWriter&) = delete;
  RowWriter& operator=(const RowWriter&) = delete;
  void append(const Row& row);

 private:
  int descriptor_;
};

}  // namespace cvr::experiments
