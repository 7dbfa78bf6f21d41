// Strict reading of JSON that somebody else may have written: rows, journals, baselines, the `info`
// of a precomputed folder.
//
// Stricter than JSON itself: nesting has a limit (a reader that goes down by recursion must not run
// out of stack), and a key may stand only once in an object. Numbers that a double cannot hold and
// text that is not UTF-8 are errors as well.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace cvr::volumes {

inline constexpr std::size_t kMaxJsonDepth = 64;  ///< levels of arrays and objects

/// One JSON value and nothing behind it. `document` names the text in errors, `line` is the number
/// of its first line there, so that a line of a file is named by its own number. Throws InputError
/// "DOCUMENT:LINE:COLUMN: expected ..., found ..."; columns count bytes from 1.
nlohmann::ordered_json parse_json(std::string_view text, const std::string& document,
                                  std::size_t line = 1);

/// The value of a file. Throws InputError, also where the file cannot be read or is no
/// regular file.
nlohmann::ordered_json read_json_file(const std::string& path);

}  // namespace cvr::volumes
