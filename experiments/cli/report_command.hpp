// The command report, for others that end with a page.
#pragma once

#include <string>
#include <vector>

#include "experiments/cli/app.hpp"

namespace cvr::experiments::cli {

struct ReportChoices {
  std::vector<std::string> results;  ///< folders with rows.jsonl
  std::string output, figures, title;
  std::string store;  ///< folder of the history; need not be there
};

/// The history's folder unless another is named.
inline std::string history_folder(const Environment& environment) {
  return environment.share + "/history";
}

/// Makes the page and prints the answers of its summary. The exit code. Throws InputError,
/// OutputError, and EnvironmentError where there is no Python with what the report needs.
int report(const ReportChoices& choices, const Environment& environment);

}  // namespace cvr::experiments::cli
