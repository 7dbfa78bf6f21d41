// Rows: the outcome of one cell each (result.hpp), as JSON lines in OUT/rows.jsonl.
//
// A kill can tear the last line at most (json_lines.hpp). A cell that was done again has several
// rows; the last one counts.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/results/json_lines.hpp"
#include "experiments/results/result.hpp"

namespace cvr::experiments {

inline constexpr std::string_view kOk = "ok";
inline constexpr std::string_view kFailed = "failed";
inline constexpr std::string_view kTimeout = "timeout";
inline constexpr std::string_view kOutOfMemory = "out-of-memory";
inline constexpr std::string_view kUnsupported = "unsupported";
inline constexpr std::string_view kDataMissing = "data-missing";

/// Voxels of the original over those of the volume that the row is about: above 1 where a part or a
/// smaller volume stands for it.
double whole_over_part(const Result& result);

/// The results of all whole rows of a file; where it does not exist, of the same file with .zst
/// behind its name (evidence is kept so), else none. A row has the texts cell, key
/// and status, one of the six; rows of other revisions may lack other fields and have fields that
/// this one does not know. Throws InputError: "FILE:LINE: ..." for a line that is no row, a key that
/// stands twice and nesting beyond volumes::kMaxJsonDepth.
std::vector<Result> load_rows(const std::string& given);

/// The last result of each cell or key.
std::map<std::string, Result> latest_by(const std::vector<Result>& results,
                                        std::string Result::*field);

/// Whether a text is one of the six statuses.
bool is_status(std::string_view text);

class RowWriter {
 public:
  /// Opens for appending; makes the file; cuts a torn last line off. Throws OutputError, and
  /// InputError while another run writes to the file.
  explicit RowWriter(const std::string& path) : lines_(path) {}
  /// Throws OutputError; the rows before stay whole.
  void append(const Result& result) {
    lines_.append(to_json(result).dump(-1, ' ', false, Row::error_handler_t::replace));
  }

 private:
  LineWriter lines_;
};

}  // namespace cvr::experiments
