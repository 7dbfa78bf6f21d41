// Where the project's own files (configs, scenes) may lie.
#pragma once

#include <filesystem>
#include <vector>

namespace cvr::experiments {

/// In the order in which to look: the current folder, the folder above that of the running program
/// (of a bundle or an installation), the source tree that the program was built from.
std::vector<std::filesystem::path> project_folders();

}  // namespace cvr::experiments
