// Files as this folder uses them: mapped for reading, and written beside their final name until
// they are complete.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cvr::volumes {

/// The bytes of a regular file, mapped read-only. A file that another program shortens while it is
/// mapped ends this one with a bus error, as with every memory map.
class MappedFile {
 public:
  /// What to do with a file larger than half of the address space that this process may have
  /// (ulimit -v): map it nevertheless, or its first 16 MiB alone, the rest by read(), so that there
  /// is room for the work.
  enum class Least : std::uint8_t { kWhole, kBegin };

  /// Throws InputError if the file is missing, a folder, or cannot be read.
  explicit MappedFile(const std::string& path, Least least = Least::kWhole);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&&) = delete;

  const std::string& path() const { return path_; }
  /// What is mapped: the whole file, or where !whole() its begin.
  std::span<const std::byte> bytes() const { return {data_, mapped_}; }
  std::string_view text() const { return {reinterpret_cast<const char*>(data_), mapped_}; }
  bool whole() const { return mapped_ == size_; }
  /// Bytes of the file.
  std::uint64_t size() const { return size_; }
  /// Copies bytes of the file that may lie behind what is mapped. Throws InputError if they are not
  /// there.
  void read(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  std::string path_;
  const std::byte* data_ = nullptr;
  std::size_t mapped_ = 0;
  std::uint64_t size_ = 0;
  int descriptor_ = -1;  ///< of a file that is not mapped whole
};

/// Throws InputError unless `path` is a readable regular file.
void require_file(const std::string& path);

/// The name of the file that writing to `path` makes or replaces: `path` itself, or the plain file
/// that it leads to as a symbolic link. Throws OutputError where that is no plain file (a folder,
/// device, pipe, socket, a link to nothing), where it may not be written, where the folder that
/// should hold it is missing, and for names below /dev and /proc, which stand for open devices and
/// pipes: outputs are files, which are written beside their names and renamed.
std::string output_target(const std::string& path);

/// Throws OutputError where `path` cannot be made or replaced as far as can be told before writing:
/// for commands that work long before they write.
void check_output(const std::string& path);

/// Throws InputError where writing one of the files or folders `outputs`, which need not exist,
/// would replace or change one of `inputs`: it is the same file by another name (relative, symbolic
/// link, hard link), lies in a folder that is an input, or is a folder that holds an input.
void refuse_to_replace(const std::vector<std::string>& outputs,
                       const std::vector<std::string>& inputs);

/// A file in the making: bytes go to "TARGET.part0" (or the next free number) beside the target
/// that output_target names, and commit renames it. Without commit it vanishes. A new file that
/// replaces another keeps its permissions. Bytes are handed to the system, not forced to the disk:
/// what it tells of a full disk or a quota is an error, what a power failure loses is lost.
class OutputFile {
 public:
  /// Throws OutputError as output_target does, or if the file cannot be made.
  explicit OutputFile(std::string path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  const std::string& path() const { return path_; }
  const std::string& partial_path() const { return partial_; }
  /// Throws OutputError, as everything below.
  void write(std::span<const std::byte> bytes);
  void write(std::string_view text) { write(std::as_bytes(std::span(text))); }
  /// Ends writing; the file keeps its temporary name. For libraries that write by name and for
  /// files that appear in pairs.
  void close();
  /// Closes, and replaces what had the final name.
  void commit();

  /// Puts both in place under their final names. `described` means nothing without `description`
  /// (voxels and their header), so the old description goes first: what is there at any moment is
  /// never new voxels with an old header. Of several programs that write the same pair one comes
  /// after the other.
  static void commit_pair(OutputFile& described, OutputFile& description);

 private:
  void rename_to_target();

  std::string path_;
  std::string target_;
  std::string partial_;
  int descriptor_ = -1;
  bool committed_ = false;
};

/// Keeps other programs that take the same lock out of a folder while one lives. Where the file
/// system knows no locks it does nothing.
class FolderLock {
 public:
  /// Waits for the lock.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

/// The whole of a file at once. Throws OutputError.
void write_whole_file(const std::string& path, std::string_view text);

}  // namespace cvr::volumes
