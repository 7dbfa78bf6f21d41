// Where the project's own files (configs, scenes, the report's program) may lie.
#pragma once

#include <filesystem>
#include <vector>

namespace cvr::experiments {

/// Those that belong to the running program, in the order in which to look: share/cvrbench beside the
/// folder of the program (of an installation), the folder above it (of a bundle), the source tree
/// that it was built from. Programs are taken from these alone.
std::vector<std::filesystem::path> program_folders();

/// In the order in which to look: the current folder, then those of the program.
std::vector<std::filesystem::path> project_folders();

}  // namespace cvr::experiments
