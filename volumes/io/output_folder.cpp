#include "volumes/io/output_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "volumes/io/file.hpp"
#include "volumes/io/precomputed.hpp"
#include "volumes/io/unfinished.hpp"

namespace cvr::volumes {

namespace {

namespace fs = std::filesystem;

constexpr int kPartialNames = 1000;

fs::path folder_of(const fs::path& target) {
  return target.parent_path().empty() ? fs::path(".") : target.parent_path();
}

/// The folder itself where it exists, whatever leads to it.
fs::path target_of(const std::string& path) {
  fs::path target(path);
  if (!target.has_filename()) target = target.parent_path();
  std::error_code error;
  if (!fs::exists(fs::symlink_status(target, error))) return target;
  fs::path whole = fs::canonical(target, error);
  if (error) throw_output_error(path, error.message());
  return whole;
}

/// Something in a folder that write_precomputed did not put there; empty where there is nothing of
/// the kind.
std::string foreign_entry(const fs::path& folder) {
  if (fs::is_empty(folder)) return {};
  const fs::path file = folder / "info";
  PrecomputedInfo info;
  try {
    if (!fs::is_regular_file(fs::symlink_status(file))) return "no file info of its own";
    info = read_precomputed_info(file.string(), "");
  } catch (const InputError& error) {
    return fmt::format("a file info that was not written here: {}", error.what());
  }
  const bool labels = info.kind == VolumeKind::kLabels;
  if (precomputed_info_text(info.data_type, labels, info.scale) !=
      MappedFile(file.string()).text()) {
    return "a file info that was not written here";
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool ours =
        name == "info" || (name == info.scale.key && fs::is_directory(entry.symlink_status()));
    if (!ours) return fmt::format("'{}' in it", name);
  }
  if (!fs::exists(folder / info.scale.key)) return {};
  for (const auto& entry : fs::directory_iterator(folder / info.scale.key)) {
    const std::string name = entry.path().filename().string();
    const bool chunk = chunk_name_fault(info.scale, name).empty() && !name.ends_with(".gz");
    if (!chunk || !fs::is_regular_file(entry.symlink_status()))
      return fmt::format("'{}/{}' in it", info.scale.key, name);
  }
  return {};
}

/// Throws unless the target may be replaced or is free.
void check_replaceable(const std::string& path, const fs::path& target) {
  const fs::file_status status = fs::status(target);
  if (!fs::exists(status)) {
    const fs::path folder = folder_of(target);
    if (!fs::is_directory(folder))
      throw_output_error(path, fmt::format("there is no folder '{}'", folder.string()));
    return;
  }
  if (!fs::is_directory(status))
    throw_output_error(path, "a file, device, pipe or socket has this name");
  const fs::path here = fs::current_path();
  for (fs::path at = here; at != at.parent_path(); at = at.parent_path()) {
    if (fs::equivalent(at, target))
      throw_output_error(path, "it is the current folder or one above it");
  }
  if (const std::string found = foreign_entry(target); !found.empty()) {
    throw_output_error(
        path,
        fmt::format(
            "it is replaced only where it is empty or holds nothing but a precomputed volume that "
            "was written here, found {}",
            found));
  }
}

}  // namespace

void check_output_folder(const std::string& path) {
  try {
    const fs::path target = target_of(path);
    const fs::path folder = folder_of(target);
    const FolderLock lock(folder);  // nobody exchanges it while it is looked at
    check_replaceable(path, target);
    if (::access(folder.c_str(), W_OK | X_OK) != 0) throw_output_error(path, std::strerror(errno));
  } catch (const fs::filesystem_error& error) {
    throw_output_error(path, error.what());
  }
}

OutputFolder::OutputFolder(std::string path) : path_(std::move(path)), target_(target_of(path_)) {
  check_output_folder(path_);
  UnfinishedOutputs unfinished;
  std::error_code error;
  bool made = false;
  for (int number = 0; number < kPartialNames && !made && !error; ++number) {
    partial_ = fmt::format("{}.part{}", target_.string(), number);
    made = fs::create_directory(partial_, error);
  }
  if (!made)
    throw_output_error(path_,
                       error ? error.message() : "a thousand unfinished folders lie beside it");
  unfinished.add(partial_.string());
}

OutputFolder::~OutputFolder() {
  if (committed_) return;
  UnfinishedOutputs unfinished;
  std::error_code ignored;
  fs::remove_all(partial_, ignored);
  unfinished.remove(partial_.string());
}

void OutputFolder::commit() {
  const FolderLock lock(folder_of(target_));
  UnfinishedOutputs unfinished;
  // A free name and an empty folder are replaced by renaming, and by nobody else at the same
  // moment.
  if (std::rename(partial_.c_str(), target_.c_str()) != 0) {
    if (errno != ENOTEMPTY && errno != EEXIST) throw_output_error(path_, std::strerror(errno));
    replace_old();
  }
  committed_ = true;
  unfinished.remove(partial_.string());
}

/// Exchanges the two in one step, so that at every moment a whole volume has the name, and removes
/// the old one.
void OutputFolder::replace_old() {
  try {
    check_replaceable(path_, target_);
  } catch (const fs::filesystem_error& error) {
    throw_output_error(path_, error.what());
  }
  if (::renameat2(AT_FDCWD, partial_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) != 0) {
    throw_output_error(path_,
                       fmt::format("it cannot be replaced here: {}; remove it or write beside it",
                                   std::strerror(errno)));
  }
  std::error_code ignored;
  fs::remove_all(partial_, ignored);
}

}  // namespace cvr::volumes
