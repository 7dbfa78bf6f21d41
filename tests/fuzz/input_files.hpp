// Targets whose subject reads files by name: a folder of this process, on memory-backed storage
// where TMPDIR says so, and what a volume that opens is asked.
#pragma once

#include <stdlib.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "tests/fuzz/target.hpp"
#include "volumes/error.hpp"
#include "volumes/io/io.hpp"

namespace cvr::fuzz {

/// A folder that goes away with the process, unless that crashes.
class InputFolder {
 public:
  InputFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "cvrbench-fuzz-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~InputFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Writes a file, and the folders above it; returns its path.
  std::string write(const std::string& name, std::string_view text) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    if (!out.flush()) std::abort();
    return file.string();
  }
  std::string write(const std::string& name, Input bytes) const {
    return write(name, text_of(bytes));
  }

 private:
  std::filesystem::path path_;
};

/// Opens a volume, asks what it is, and reads it and its last voxel. InputError is an answer;
/// anything else that is thrown is not.
inline void exercise_volume(const std::string& path, const volumes::OpenOptions& options = {}) {
  constexpr std::uint64_t kLargest = std::uint64_t{1} << 22;
  try {
    const auto source = volumes::open_volume(path, options);
    const volumes::VolumeInfo& info = source->info();
    source->files();
    if (info.bytes() <= kLargest) volumes::read_all(*source);
    const volumes::Extent& e = info.extent;
    std::byte voxel[8];
    source->read({{e.x - 1, e.y - 1, e.z - 1}, {1, 1, 1}}, voxel);
  } catch (const volumes::InputError&) {
    return;
  }
}

}  // namespace cvr::fuzz
