#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "experiments/cli/commands.hpp"
#include "experiments/project_folders.hpp"
#include "volumes/io/file.hpp"

namespace cvr::experiments::cli {

namespace fs = std::filesystem;

volumes::Extent parse_extent(const std::string& text) {
  std::array<std::uint64_t, 3> axes{};
  const char* at = text.data();
  const char* end = text.data() + text.size();
  bool good = true;
  for (std::size_t a = 0; a < 3 && good; ++a) {
    const auto [next, error] = std::from_chars(at, end, axes[a]);
    good = error == std::errc{} && axes[a] >= 1 && axes[a] <= (std::uint64_t{1} << 20) &&
           (a == 2 ? next == end : next != end && *next == ',');
    at = next + 1;
  }
  if (!good)
    throw volumes::InputError(
        fmt::format("--size {}: expected X,Y,Z with each 1..1048576, found '{}'", text, text));
  return {axes[0], axes[1], axes[2]};
}

volumes::Buffer read_file(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error))
    throw volumes::InputError(fmt::format("{}: expected an encoded file, found a folder", path));
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw volumes::InputError(
        fmt::format("{}: expected a readable file, found: {}", path, std::strerror(errno)));
  const std::uint64_t size = fs::file_size(path, error);
  if (error)
    throw volumes::InputError(fmt::format("{}: expected a regular file, found: {}", path, error.message()));
  volumes::Buffer bytes(size);
  if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
    throw volumes::InputError(fmt::format("{}: expected {} bytes, found {}", path, size, in.gcount()));
  }
  return bytes;
}

void write_file(const std::string& path, std::span<const std::byte> bytes) {
  volumes::OutputFile file(path);
  file.write(bytes);
  file.commit();
}

void print_json(const Row& object) {
  fmt::print("{}\n", object.dump(2, ' ', false, Row::error_handler_t::replace));
}

void fail_on_file(const std::string& path, const volumes::Error& error) {
  throw volumes::InputError(fmt::format("{}: {}", path, error.message));
}

std::string find_catalogue(const std::string& given, const std::string& config_path) {
  if (!given.empty()) return given;
  std::vector<fs::path> places;
  if (!config_path.empty()) {
    const fs::path folder = fs::absolute(config_path).parent_path();
    places = {folder / "datasets", folder.parent_path() / "datasets"};
  }
  for (const fs::path& folder : project_folders()) places.push_back((folder / "configs" / "datasets").lexically_normal());
  std::error_code error;
  for (const fs::path& place : places) {
    if (fs::is_directory(place, error)) return place.string();
  }
  throw volumes::InputError(
      "expected a folder of data set descriptions (--datasets DIR), found none beside the configuration");
}

}  // namespace cvr::experiments::cli
