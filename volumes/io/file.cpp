#include "volumes/io/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "volumes/io/format.hpp"

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

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  struct stat status {};
  if (::stat(path_.c_str(), &status) == 0 && S_ISDIR(status.st_mode)) {
    throw_input_error(path_, "", "a name for a file", "a folder of this name");
  }
  for (int number = 0; number < kPartialNames && descriptor_ < 0; ++number) {
    partial_ = fmt::format("{}.part{}", path_, number);
    descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno != EEXIST) break;
  }
  if (descriptor_ < 0) throw_input_error(path_, "", "a name that can be written", std::strerror(errno));
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!committed_) ::unlink(partial_.c_str());
}

void OutputFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), std::min<std::size_t>(bytes.size(), 1u << 30));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw_input_error(path_, "", "room to write", std::strerror(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void OutputFile::close() {
  if (descriptor_ < 0) return;
  if (::close(std::exchange(descriptor_, -1)) != 0)
    throw_input_error(path_, "", "room to write", std::strerror(errno));
}

void OutputFile::commit() {
  close();
  if (std::rename(partial_.c_str(), path_.c_str()) != 0) {
    throw_input_error(path_, "", "a name that can be replaced", std::strerror(errno));
  }
  committed_ = true;
}

}  // namespace cvr::volumes
