#include "volumes/io/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "volumes/io/format.hpp"
#include "volumes/io/unfinished.hpp"

namespace cvr::volumes {

namespace {

constexpr int kPartialNames = 1000;

std::uint64_t checked_file_size(const std::string& path, int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) throw_input_error(path, "", "a readable file", std::strerror(errno));
  if (S_ISDIR(status.st_mode)) throw_input_error(path, "", "a file", "a folder");
  if (!S_ISREG(status.st_mode)) throw_input_error(path, "", "a regular file", "a device, pipe or socket");
  return static_cast<std::uint64_t>(status.st_size);
}

int open_for_reading(const std::string& path) {
  // O_NONBLOCK: a pipe without a writer must not hang; it has no effect on regular files.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) throw_input_error(path, "", "a readable file", std::strerror(errno));
  return descriptor;
}

class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  ~Descriptor() { ::close(descriptor_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

/// The folder that holds a name.
std::string folder_of(const std::string& path) {
  const std::filesystem::path name(path);
  const std::filesystem::path folder = (name.has_filename() ? name : name.parent_path()).parent_path();
  return folder.empty() ? "." : folder.string();
}

/// What is the same for all names of a file or folder; none where there is nothing.
using Identity = std::pair<dev_t, ino_t>;
std::optional<Identity> identity_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return Identity{status.st_dev, status.st_ino};
}

/// Whether one of the folders above `path`, which need not exist, is this one.
bool lies_in(const std::string& path, const Identity& folder) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(path, error);
  if (error) return false;
  for (std::filesystem::path at = whole.parent_path();; at = at.parent_path()) {
    if (identity_of(at.string()) == folder) return true;
    if (at == at.parent_path()) return false;
  }
}

}  // namespace

MappedFile::MappedFile(const std::string& path) : path_(path) {
  const Descriptor file(open_for_reading(path));
  size_ = checked_file_size(path, file.get());
  if (size_ == 0) return;
  void* mapped = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, file.get(), 0);
  if (mapped == MAP_FAILED) {
    size_ = 0;
    throw_input_error(path, "", "a file that can be mapped", std::strerror(errno));
  }
  data_ = static_cast<const std::byte*>(mapped);
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : path_(std::move(other.path_)),
      data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

void require_file(const std::string& path) {
  const Descriptor file(open_for_reading(path));
  checked_file_size(path, file.get());
}

std::string output_target(const std::string& path) {
  if (path.empty()) throw_output_error("''", "a name is missing");
  const bool device =
      (path.starts_with("/dev/") && !path.starts_with("/dev/shm/")) || path.starts_with("/proc/");
  if (device) throw_output_error(path, "it names a device or an open file, and outputs are plain files");
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    const int reason = errno;
    if (reason != ENOENT) throw_output_error(path, std::strerror(reason));
    if (::lstat(path.c_str(), &status) == 0)
      throw_output_error(path, "it is a symbolic link to a file that is missing");
    const std::string folder = folder_of(path);
    if (::stat(folder.c_str(), &status) != 0)
      throw_output_error(path, fmt::format("there is no folder '{}'", folder));
    return path;
  }
  if (S_ISDIR(status.st_mode)) throw_output_error(path, "a folder has this name");
  if (!S_ISREG(status.st_mode)) {
    throw_output_error(path, "a device, pipe or socket has this name, and only plain files are replaced");
  }
  if (::access(path.c_str(), W_OK) != 0) throw_output_error(path, std::strerror(errno));
  const std::unique_ptr<char, decltype(&std::free)> resolved(::realpath(path.c_str(), nullptr), &std::free);
  if (!resolved) throw_output_error(path, std::strerror(errno));
  return resolved.get();
}

void check_output(const std::string& path) {
  const std::string folder = folder_of(output_target(path));
  if (::access(folder.c_str(), W_OK | X_OK) != 0) throw_output_error(path, std::strerror(errno));
}

void refuse_to_replace(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    const auto read = identity_of(input);
    if (!read) continue;
    for (const std::string& output : outputs) {
      const auto written = identity_of(output);
      if (written == read) {
        throw_input_error(output, "", "another file than the input",
                          fmt::format("'{}', which is read", input));
      }
      if (lies_in(output, *read)) {
        throw_input_error(output, "", "a place outside the input",
                          fmt::format("the folder '{}', which is read", input));
      }
      if (written && lies_in(input, *written)) {
        throw_input_error(output, "", "a folder without the input",
                          fmt::format("'{}' in it, which is read", input));
      }
    }
  }
}

OutputFile::OutputFile(std::string path) : path_(std::move(path)), target_(output_target(path_)) {
  struct stat old {};
  const bool replaces = ::stat(target_.c_str(), &old) == 0;
  UnfinishedOutputs unfinished;
  for (int number = 0; number < kPartialNames && descriptor_ < 0; ++number) {
    partial_ = fmt::format("{}.part{}", target_, number);
    descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno != EEXIST) break;
  }
  if (descriptor_ < 0) throw_output_error(path_, std::strerror(errno));
  unfinished.add(partial_);
  if (replaces)
    static_cast<void>(
        ::fchmod(descriptor_, old.st_mode & 0777));  // a file system without modes has none to keep
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (committed_) return;
  UnfinishedOutputs unfinished;
  ::unlink(partial_.c_str());
  unfinished.remove(partial_);
}

void OutputFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), std::min<std::size_t>(bytes.size(), 1u << 30));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw_output_error(path_, std::strerror(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void OutputFile::close() {
  if (descriptor_ < 0) return;
  if (::close(std::exchange(descriptor_, -1)) != 0) throw_output_error(path_, std::strerror(errno));
}

void OutputFile::commit() {
  close();
  UnfinishedOutputs unfinished;
  rename_to_target();
  unfinished.remove(partial_);
}

void OutputFile::commit_pair(OutputFile& described, OutputFile& description) {
  described.close();
  description.close();
  const FolderLock lock(folder_of(described.target_));
  UnfinishedOutputs unfinished;
  if (::unlink(description.target_.c_str()) != 0 && errno != ENOENT) {
    throw_output_error(description.path_, std::strerror(errno));
  }
  for (OutputFile* file : {&described, &description}) {
    file->rename_to_target();
    unfinished.remove(file->partial_);
  }
}

void OutputFile::rename_to_target() {
  if (std::rename(partial_.c_str(), target_.c_str()) != 0) throw_output_error(path_, std::strerror(errno));
  committed_ = true;
}

FolderLock::FolderLock(const std::string& folder)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  while (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) continue;
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void write_whole_file(const std::string& path, std::string_view text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace cvr::volumes
