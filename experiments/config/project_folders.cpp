#include "experiments/config/project_folders.hpp"

#include <system_error>

#include "experiments/results/build_info.hpp"

namespace cvr::experiments {

std::vector<std::filesystem::path> program_folders() {
  std::vector<std::filesystem::path> folders;
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    const auto prefix = program.parent_path().parent_path();
    folders.push_back(prefix / "share" / "cvrbench");
    folders.push_back(prefix);
  }
  folders.emplace_back(build_info::kSourceFolder);
  return folders;
}

std::vector<std::filesystem::path> project_folders() {
  auto folders = program_folders();
  folders.insert(folders.begin(), ".");
  return folders;
}

}  // namespace cvr::experiments
