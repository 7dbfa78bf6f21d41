// Files of JSON lines that grow while a run goes on and may have been cut by a kill: rows.jsonl and
// journal.jsonl.
//
// A line is appended with one write and an fsync, so a kill can tear the last line at most. Reading
// passes over a torn last line, and appending cuts it off. Lines have a largest length, so that no
// file takes more memory than its longest line.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace cvr::experiments {

inline constexpr std::uint64_t kLongestLine =
    std::uint64_t{256} << 20;  ///< bytes; 10^6 rounds with all samples take 40 MiB

/// Of a file whose lines are compressed by Zstandard; such files are read and not written.
inline constexpr std::string_view kCompressedEnding = ".zst";

/// Calls `use` with number (from 1) and text of each line of a file that has its end; none where
/// there is no file. Throws InputError where the file cannot be read or is no regular file, and
/// "FILE:LINE: ..." for a line longer than `longest` bytes.
void for_each_line(const std::string& path,
                   const std::function<void(std::size_t, std::string_view)>& use,
                   std::uint64_t longest = kLongestLine);

/// A descriptor with an exclusive lock that ends with it, also by a kill.
class LockedFile {
 public:
  /// Opens for appending, makes the file where there is none. Throws OutputError where that fails.
  /// While somebody else holds the lock it waits as long as `wait` says, by default for a second,
  /// then throws InputError.
  explicit LockedFile(const std::string& path, const std::function<bool()>& wait = {});
  ~LockedFile();
  LockedFile(const LockedFile&) = delete;
  LockedFile& operator=(const LockedFile&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

class LineWriter {
 public:
  /// Cuts a torn last line off. Throws as LockedFile.
  explicit LineWriter(const std::string& path);
  /// Appends the text and a line end. Throws OutputError; the file then ends with the last line
  /// that was whole.
  void append(const std::string& text);

 private:
  std::string path_;
  LockedFile file_;
};

}  // namespace cvr::experiments
