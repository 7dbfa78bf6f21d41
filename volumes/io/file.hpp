// Files as this folder uses them: mapped for reading, and written beside their final name until they are
// complete.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace cvr::volumes {

/// The bytes of a regular file, mapped read-only. A file that another program shortens while it is mapped
/// ends this one with a bus error, as with every memory map.
class MappedFile {
 public:
  /// What to do with a file larger than half of the address space that this process may have (ulimit -v): map it nevertheless, or its
  /// first 16 MiB alone, the rest by read(), so that there is room for the work.
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
  /// Copies bytes of the file that may lie behind what is mapped. Throws InputError if they are not there.
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

/// A file in the making: bytes go to "PATH.part0" (or the next free number), which commit renames. Without
/// commit it vanishes.
class OutputFile {
 public:
  /// Throws InputError if the name is taken by a folder or the file cannot be made.
  explicit OutputFile(std::string path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  const std::string& path() const { return path_; }
  const std::string& partial_path() const { return partial_; }
  void write(std::span<const std::byte> bytes);
  void write(std::string_view text) { write(std::as_bytes(std::span(text))); }
  /// Ends writing; the file keeps its temporary name. For libraries that write by name and for files that
  /// appear in pairs.
  void close();
  /// Closes, and replaces whatever had the final name.
  void commit();

 private:
  std::string path_;
  std::string partial_;
  int descriptor_ = -1;
  bool committed_ = false;
};

}  // namespace cvr::volumes
