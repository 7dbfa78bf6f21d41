#include "experiments/analysis/csv.hpp"

#include "experiments/analysis/escaping.hpp"

namespace cvr::experiments {

std::string csv_text(const std::vector<std::vector<std::string>>& lines,
                     std::string_view line_end) {
  std::string text;
  for (const std::vector<std::string>& line : lines) {
    std::string_view separator;
    for (const std::string& field : line) {
      text.append(separator).append(escape_csv(field));
      separator = ",";
    }
    text += line_end;
  }
  return text;
}

}  // namespace cvr::experiments
