// Lines of fields as CSV (RFC 4180), for tables and for rows.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cvr::experiments {

/// One line a list of fields, each escaped (escaping.hpp) and ended by `line_end`.
std::string csv_text(const std::vector<std::vector<std::string>>& lines,
                     std::string_view line_end = "\n");

}  // namespace cvr::experiments
