#include "volumes/io/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
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
constexpr std::size_t kBeginBytes = std::size_t{16} << 20;

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

/// The bytes of address space that this process may have.
std::uint64_t address_space() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return ~std::uint64_t{0};
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
    const ssize_t got = descriptor_ < 0 ? 0 : ::pread(descriptor_, out.data(), piece, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      throw_input_error(path_, fmt::format("byte {}", offset), fmt::format("{} more bytes", out.size()),
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
