// Names of keys, metrics and labels that have changed: users may type the former ones for one
// release more (CHANGELOG.md). Rows keep the names that they have always had.
#pragma once

#include <string_view>

namespace cvr::experiments {

/// The name of today; the same one where it has not changed.
std::string_view current_name(std::string_view name);
/// What it was called before; empty where it has not changed.
std::string_view former_name(std::string_view name);

}  // namespace cvr::experiments
