// Rows: the outcome of one cell each, as JSON lines in OUT/rows.jsonl
// (results/schema/row.schema.json says what a row holds).
//
// A kill can tear the last line at most (json_lines.hpp). A cell that was done again has several
// rows; the last one counts.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/results/json_lines.hpp"

namespace cvr::experiments {

using Row = nlohmann::ordered_json;

inline constexpr std::string_view kOk = "ok";
inline constexpr std::string_view kFailed = "failed";
inline constexpr std::string_view kTimeout = "timeout";
inline constexpr std::string_view kOutOfMemory = "out-of-memory";
inline constexpr std::string_view kUnsupported = "unsupported";
inline constexpr std::string_view kDataMissing = "data-missing";

/// Voxels of the original over those of the volume that the row is about: above 1 where a part or a
/// smaller volume stands for it.
double whole_over_part(const Row& row);

/// All whole rows of a file, none if it does not exist. A row has the texts cell, key and status,
/// one of the six, and objects where results/schema has them. Throws InputError: "FILE:LINE: ..."
/// for a line that is no row, a key that stands twice and nesting beyond volumes::kMaxJsonDepth.
std::vector<Row> load_rows(const std::string& path);

/// The last row of each value of a text field, for instance "cell" or "key".
std::map<std::string, Row> latest_by(const std::vector<Row>& rows, const std::string& field);

/// Whether a text is one of the six statuses.
bool is_status(std::string_view text);

class RowWriter {
 public:
  /// Opens for appending; makes the file; cuts a torn last line off. Throws OutputError, and
  /// InputError while another run writes to the file.
  explicit RowWriter(const std::string& path) : lines_(path) {}
  /// Throws OutputError; the rows before stay whole.
  void append(const Row& row) {
    lines_.append(row.dump(-1, ' ', false, Row::error_handler_t::replace));
  }

 private:
  LineWriter lines_;
};

}  // namespace cvr::experiments
