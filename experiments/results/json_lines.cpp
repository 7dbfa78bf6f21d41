#include "experiments/results/json_lines.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <thread>
#include <vector>

#include "volumes/error.hpp"

namespace cvr::experiments {

namespace {

using volumes::InputError;
using volumes::OutputError;

constexpr std::size_t kBlock = std::size_t{1} << 18;
/// A process that was killed between starting a worker and the worker's begin leaves its locks to a
/// process that is about to end.
constexpr std::chrono::milliseconds kLockPatience{1000}, kLockPause{5};

[[noreturn]] void fail_to_write(const std::string& path) {
  throw OutputError(fmt::format("{}: cannot write: {}", path, std::strerror(errno)));
}

class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  ~Descriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

/// 0, or the error; EWOULDBLOCK while somebody else holds the lock.
int lock_in_time(int descriptor, const std::function<bool()>& wait) {
  const auto deadline = std::chrono::steady_clock::now() + kLockPatience;
  while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) return errno;
    if (wait ? !wait() : std::chrono::steady_clock::now() >= deadline) return EWOULDBLOCK;
    std::this_thread::sleep_for(kLockPause);
  }
  return 0;
}

/// Bytes up to the end of the last whole line.
off_t whole_lines(int descriptor, off_t size) {
  std::array<char, 4096> block;
  for (off_t end = size; end > 0;) {
    const off_t begin = std::max<off_t>(0, end - static_cast<off_t>(block.size()));
    const ssize_t got =
        ::pread(descriptor, block.data(), static_cast<std::size_t>(end - begin), begin);
    if (got <= 0) return size;
    const std::string_view text(block.data(), static_cast<std::size_t>(got));
    if (const std::size_t newline = text.rfind('\n'); newline != std::string_view::npos)
      return begin + static_cast<off_t>(newline) + 1;
    end = begin;
  }
  return 0;
}

/// Cuts what comes in blocks into lines.
class LineSplitter {
 public:
  LineSplitter(const std::string& path,
               const std::function<void(std::size_t, std::string_view)>& use, std::uint64_t longest)
      : path_(path), use_(use), longest_(longest) {}

  void add(std::string_view rest) {
    for (std::size_t end = 0; (end = rest.find('\n')) != std::string_view::npos;
         rest.remove_prefix(end + 1), ++number_) {
      check_length(begun_.size() + end);
      if (begun_.empty()) {
        use_(number_, rest.substr(0, end));
      } else {
        begun_.append(rest.substr(0, end));
        use_(number_, begun_);
        begun_.clear();
      }
    }
    begun_.append(rest);
    check_length(begun_.size());
  }

 private:
  void check_length(std::size_t length) const {
    if (length > longest_)
      throw InputError(fmt::format("{}:{}: expected lines of at most {} bytes, found a longer one",
                                   path_, number_, longest_));
  }

  const std::string& path_;
  const std::function<void(std::size_t, std::string_view)>& use_;
  std::uint64_t longest_;
  std::string begun_;  ///< of the line that goes on behind the block
  std::size_t number_ = 1;
};

/// A file of Zstandard frames, block by block.
class Decompression {
 public:
  explicit Decompression(const std::string& path)
      : path_(path), stream_(ZSTD_createDCtx(), ZSTD_freeDCtx), out_(kBlock) {
    if (!stream_) throw std::bad_alloc();
  }

  void add(std::string_view bytes, LineSplitter& lines) {
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    bool filled = false;  // more of the same input may come out
    while (in.pos < in.size || filled) {
      ZSTD_outBuffer out{out_.data(), out_.size(), 0};
      left_ = ZSTD_decompressStream(stream_.get(), &out, &in);
      if (ZSTD_isError(left_) != 0)
        throw InputError(fmt::format("{}: expected Zstandard frames, found: {}", path_,
                                     ZSTD_getErrorName(left_)));
      lines.add({out_.data(), out.pos});
      filled = out.pos == out.size && left_ != 0;
    }
  }
  void end() const {
    if (left_ != 0)
      throw InputError(
          fmt::format("{}: expected a whole Zstandard frame, found the file's end", path_));
  }

 private:
  const std::string& path_;
  std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> stream_;
  std::vector<char> out_;
  std::size_t left_ = 1;  ///< 0: a frame has ended
};

}  // namespace

void for_each_line(const std::string& path,
                   const std::function<void(std::size_t, std::string_view)>& use,
                   std::uint64_t longest) {
  // O_NONBLOCK: a pipe without a writer must not hang.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0 && errno == ENOENT) return;
  struct stat status {};
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0)
    throw InputError(
        fmt::format("{}: expected a readable file, found: {}", path, std::strerror(errno)));
  if (!S_ISREG(status.st_mode))
    throw InputError(
        fmt::format("{}: expected a regular file, found {}", path,
                    S_ISDIR(status.st_mode) ? "a folder" : "a device, pipe or socket"));
  LineSplitter lines(path, use, longest);
  std::optional<Decompression> packed;
  if (path.ends_with(kCompressedEnding)) packed.emplace(path);
  std::vector<char> block(kBlock);
  while (true) {
    const ssize_t got = ::read(file.get(), block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      throw InputError(
          fmt::format("{}: expected a readable file, found: {}", path, std::strerror(errno)));
    if (got == 0) break;
    const std::string_view bytes(block.data(), static_cast<std::size_t>(got));
    if (packed) {
      packed->add(bytes, lines);
    } else {
      lines.add(bytes);
    }
  }
  if (packed) packed->end();
}

LockedFile::LockedFile(const std::string& path, const std::function<bool()>& wait)
    : descriptor_(
          ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0644)) {
  if (descriptor_ < 0) fail_to_write(path);
  if (const int error = lock_in_time(descriptor_, wait); error != 0) {
    ::close(descriptor_);
    errno = error;
    if (error != EWOULDBLOCK) fail_to_write(path);
    throw InputError(
        fmt::format("{}: expected to be the only run that writes here, found another one", path));
  }
}

LockedFile::~LockedFile() { ::close(descriptor_); }

LineWriter::LineWriter(const std::string& path) : path_(path), file_(path) {
  struct stat status {};
  if (::fstat(file_.descriptor(), &status) != 0) fail_to_write(path_);
  if (!S_ISREG(status.st_mode))
    throw OutputError(fmt::format("{}: cannot write: it is no regular file", path_));
  const off_t whole = whole_lines(file_.descriptor(), status.st_size);
  if (whole != status.st_size && ::ftruncate(file_.descriptor(), whole) != 0) fail_to_write(path_);
}

void LineWriter::append(const std::string& text) {
  const std::string line = text + "\n";
  struct stat before {};
  if (::fstat(file_.descriptor(), &before) != 0) fail_to_write(path_);
  std::string_view rest = line;
  while (!rest.empty()) {
    const ssize_t written = ::write(file_.descriptor(), rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) break;
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  if (rest.empty() && ::fsync(file_.descriptor()) == 0) return;
  const int error = errno;
  // Where even this fails, the next run cuts the torn line off.
  [[maybe_unused]] const int cut = ::ftruncate(file_.descriptor(), before.st_size);
  errno = error;
  fail_to_write(path_);
}

}  // namespace cvr::experiments
