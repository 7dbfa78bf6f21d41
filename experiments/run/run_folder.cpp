#include "experiments/run/run_folder.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <mutex>
#include <regex>

#include "volumes/error.hpp"

namespace cvr::experiments {

namespace {

namespace fs = std::filesystem;

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path))
    throw volumes::OutputError(fmt::format(
        "{}: cannot write: {}", path, error ? error.message() : "there is a file of this name"));
}

/// Removes the plain files of a folder whose whole name matches. What cannot be removed stays.
void remove_files(const fs::path& folder, const std::string& pattern) {
  const std::regex names(pattern);
  std::error_code error;
  for (const auto& file : fs::directory_iterator(folder, error)) {
    std::error_code ignored;
    if (file.symlink_status(ignored).type() == fs::file_type::regular &&
        std::regex_match(file.path().filename().string(), names)) {
      fs::remove(file, ignored);
    }
  }
}

}  // namespace

RunLock::RunLock(const std::string& folder) : file_((fs::path(folder) / ".lock").string()) {}

std::shared_ptr<const RunLock> RunLock::take(const std::string& folder) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<const RunLock>> held;
  make_folder(folder);
  const std::string name = fs::canonical(folder).string();
  const std::scoped_lock guard(mutex);
  auto lock = held[name].lock();
  if (!lock) held[name] = lock = std::make_shared<const RunLock>(name);
  return lock;
}

RunFolder::RunFolder(const std::string& out)
    : out_(out),
      scratch_((fs::path(out) / "scratch").string()),
      lock_(RunLock::take(out)),
      rows_(file("rows.jsonl")) {
  for (const auto& [folder, endings] :
       {std::pair{"tables", "md|csv|tex|json"}, {"claims", "md|jsonl"}, {"pictures", "png"}})
    remove_files(fs::path(out_) / folder, fmt::format(R"(.+\.({})\.part\d+)", endings));
  remove_files(out_, R"(codecs\.json\.part\d+)");
  empty_scratch();
  make_folder(scratch_);
}

RunFolder::~RunFolder() {
  empty_scratch();
  std::error_code ignored;
  fs::remove(scratch_, ignored);  // unless somebody keeps other files there
}

std::string RunFolder::file(const std::string& name) const {
  return (fs::path(out_) / name).string();
}

void RunFolder::empty_scratch() const {
  remove_files(scratch_, R"([0-9a-f]{16}(-[0-9a-f]{16})?\.(cvr|picture|verified)(\.\d+)?)");
}

}  // namespace cvr::experiments
