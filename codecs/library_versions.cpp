#include "codecs/library_versions.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <lzma.h>
#include <xxhash.h>
#include <zfp.h>
#include <zlib.h>
#include <zstd.h>

#include <filesystem>

#include "codecs/astc/library.hpp"

namespace cvr::codecs {

namespace {

/// "4.2.0" of the file libNAME.so.4.2.0 that a function was loaded from; "unknown" where it is part
/// of the program.
template <class Function>
std::string version_of_file(Function* function) {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(function), &info) == 0 || info.dli_fname == nullptr)
    return "unknown";
  std::error_code error;
  const std::string file = std::filesystem::canonical(info.dli_fname, error).filename().string();
  const std::size_t at = file.find(".so.");
  return error || at == std::string::npos ? "unknown" : file.substr(at + 4);
}

std::string hdf5_version() {
  unsigned major = 0, minor = 0, release = 0;
  if (H5get_libversion(&major, &minor, &release) < 0) return "unknown";
  return fmt::format("{}.{}.{}", major, minor, release);
}

/// 0xabcd: a.b.c.d, the last part where it is not 0.
std::string zfp_version() {
  const unsigned v = zfp_library_version;
  const std::string version = fmt::format("{}.{}.{}", v >> 12, (v >> 8) & 15, (v >> 4) & 15);
  return (v & 15) == 0 ? version : fmt::format("{}.{}", version, v & 15);
}

std::string xxhash_version() {
  const unsigned v = XXH_versionNumber();
  return fmt::format("{}.{}.{}", v / 10000, v / 100 % 100, v % 100);
}

}  // namespace

std::map<std::string, std::string> library_versions() {
  return {{"zstd", ZSTD_versionString()}, {"liblzma", lzma_version_string()},
          {"zlib", zlibVersion()},        {"hdf5", hdf5_version()},
          {"zfp", zfp_version()},         {"astcenc", version_of_file(astcenc_config_init)},
          {"xxhash", xxhash_version()}};
}

}  // namespace cvr::codecs
