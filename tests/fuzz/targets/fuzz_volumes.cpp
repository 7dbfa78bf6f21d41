// libFuzzer: volume files. The first byte chooses the format, the rest is the file, written to memory-backed storage.
// Only InputError may come out of the readers.
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "volumes/io/io.hpp"

namespace {

/// A folder of this process alone, for the whole run.
const std::string& folder() {
  static const std::string kFolder = [] {
    std::string name = (std::filesystem::temp_directory_path() / "fuzz_volumes.XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    return name;
  }();
  return kFolder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const std::vector<std::string> kNames{"v.nrrd", "v.nhdr",     "v.nii",           "v.nii.gz",
                                               "v.h5",   "v.raw.yaml", "precomputed/info"};
  const std::string& name = kNames[data[0] % kNames.size()];
  const std::filesystem::path path = folder() + '/' + name;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data + 1), static_cast<std::streamsize>(size - 1));
  std::string opened = path.string();
  if (name == "v.raw.yaml") {
    opened.resize(opened.size() - 5);
    std::ofstream(opened, std::ios::binary) << std::string(64, '\1');
  } else if (name == "precomputed/info") {
    opened = path.parent_path().string();
  }
  constexpr std::uint64_t kLargest = std::uint64_t{1} << 22;
  try {
    const auto source = cvr::volumes::open_volume(opened);
    if (source->info().bytes() <= kLargest) cvr::volumes::read_all(*source);
  } catch (const cvr::volumes::InputError&) {
    return 0;
  }
  return 0;
}
