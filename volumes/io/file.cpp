#include "volumes/io/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/resource.h>
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
constexpr std::size_t kBeginBytes = std::size_t{16} << 20;

std::uint64_t checked_file_size(const std::string& path, int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0)
    throw_input_error(path, "", "a readable file", std::strerror(errno));
  if (S_ISDIR(status.st_mode)) throw_input_error(path, "", "a file", "a folder");
  if (!S_ISREG(status.st_mode))
    throw_input_error(path, "", "a regular file", "a device, pipe or socket");
  return static_cast<std::uint64_t>(status.st_size);
}

int open_for_reading(const std::string& path) {
  // O_NONBLOCK: a pipe without a writer must not hang; it has no effect on regular files.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) throw_input_error(path, "", "a readable file", std::strerror(errno));
  return descriptor;
}

/// The bytes of address space that this process may have.
std::uint64_t address_space() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
    return ~std::uint64_t{0};
  return limit.rlim_cur;
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
  const std::filesystem::path folder =
      (name.has_filename() ? name : name.parent_path()).parent_path();
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

MappedFile::MappedFile(const std::string& path, Least least) : path_(path) {
  const Descriptor file(open_for_reading(path));
  size_ = mapped_ = checked_file_size(path, file.get());
  if (size_ == 0) return;
  if (least == Least::kBegin && size_ > std::max<std::uint64_t>(kBeginBytes, address_space() / 2)) {
    mapped_ = kBeginBytes;
    descriptor_ = ::fcntl(file.get(), F_DUPFD_CLOEXEC, 0);
  }
  void* mapped = ::mmap(nullptr, mapped_, PROT_READ, MAP_SHARED, file.get(), 0);
  if (mapped == MAP_FAILED || (!whole() && descriptor_ < 0)) {
    const int error = errno;
    if (mapped != MAP_FAILED) ::munmap(mapped, mapped_);
    if (descriptor_ >= 0) ::close(descriptor_);
    throw_input_error(path, "", fmt::format("room to map {} bytes", mapped_), std::strerror(error));
  }
  data_ = static_cast<const std::byte*>(mapped);
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), mapped_);
  if (descriptor_ >= 0) ::close(descriptor_);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : path_(std::move(other.path_)),
      data_(std::exchange(other.data_, nullptr)),
      mapped_(std::exchange(other.mapped_, 0)),
      size_(std::exchange(other.size_, 0)),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

void MappedFile::read(std::uint64_t offset, std::span<std::byte> out) const {
  if (offset <= mapped_ && out.size() <= mapped_ - offset) {
    if (!out.empty()) std::memcpy(out.data(), data_ + offset, out.size());
    return;
  }
  while (!out.empty()) {
    const std::size_t piece = std::min<std::size_t>(out.size(), 1u << 30);
    const ssize_t got =
        descriptor_ < 0 ? 0 : ::pread(descriptor_, out.data(), piece, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      throw_input_error(path_, fmt::format("byte {}", offset),
                        fmt::format("{} more bytes", out.size()),
                        got < 0 ? std::strerror(errno) : "the end of the file");
    }
    offset += static_cast<std::uint64_t>(got);
    out = out.subspan(static_cast<std::size_t>(got));
  }
}

void require_file(const std::string& path) {
  const Descriptor file(open_for_reading(path));
  checked_file_size(path, file.get());
}

std::string output_target(const std::string& path) {
  if (path.empty()) throw_output_error("''", "a name is missing");
  const bool device =
      (path.starts_with("/dev/") && !path.starts_with("/dev/shm/")) || path.starts_with("/proc/");
  if (device)
    throw_output_error(path, "it names a device or an open file, and outputs are plain files");
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    const int reason = errno;
    if (reason != ENOENT) throw_output_error(path, std::strerror(reason));
    const bool link = ::lstat(path.c_str(), &status) == 0 && S_ISLNK(status.st_mode);
    if (link) throw_output_error(path, "it is a symbolic link to a file that is missing");
    const std::string folder = folder_of(path);
    if (::stat(folder.c_str(), &status) != 0)
      throw_output_error(path, fmt::format("there is no folder '{}'", folder));
    return path;
  }
  if (S_ISDIR(status.st_mode)) throw_output_error(path, "a folder has this name");
  if (!S_ISREG(status.st_mode)) {
    throw_output_error(path,
                       "a device, pipe or socket has this name, and only plain files are replaced");
  }
  // Another writer of the same name may take the file away at any moment, to put its own there.
  const bool writable = ::access(path.c_str(), W_OK) == 0;
  if (!writable && errno != ENOENT) throw_output_error(path, std::strerror(errno));
  const std::unique_ptr<char, decltype(&std::free)> resolved(::realpath(path.c_str(), nullptr),
                                                             &std::free);
  if (!resolved && errno != ENOENT) throw_output_error(path, std::strerror(errno));
  if (!writable || !resolved) return path;
  return resolved.get();
}

void check_output(const std::string& path) {
  const std::string folder = folder_of(output_target(path));
  if (::access(folder.c_str(), W_OK | X_OK) != 0) throw_output_error(path, std::strerror(errno));
}

void refuse_to_replace(const std::vector<std::string>& outputs,
                       const std::vector<std::string>& inputs) {
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
    const ssize_t written =
        ::write(descriptor_, bytes.data(), std::min<std::size_t>(bytes.size(), 1u << 30));
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
  if (std::rename(partial_.c_str(), target_.c_str()) != 0)
    throw_output_error(path_, std::strerror(errno));
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
