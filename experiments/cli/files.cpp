#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>

#include "experiments/cli/commands.hpp"
#include "experiments/config/project_folders.hpp"
#include "volumes/io/file.hpp"
#include "volumes/number_text.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace fs = std::filesystem;

volumes::Extent parse_extent(const std::string& text) {
  constexpr std::uint64_t kMostOfAxis = std::uint64_t{1} << 20;
  const std::size_t first = text.find(','), second = text.find(',', first + 1);
  std::array<std::optional<std::uint64_t>, 3> axes;
  if (first != std::string::npos && second != std::string::npos) {
    axes = {volumes::parse_unsigned(text.substr(0, first)),
            volumes::parse_unsigned(text.substr(first + 1, second - first - 1)),
            volumes::parse_unsigned(text.substr(second + 1))};
  }
  const bool good = std::ranges::all_of(
      axes, [](const auto& axis) { return axis && *axis >= 1 && *axis <= kMostOfAxis; });
  if (!good)
    throw volumes::InputError(
        fmt::format("--size: expected X,Y,Z with each 1..{}, found '{}'", kMostOfAxis, text));
  const volumes::Extent extent{*axes[0], *axes[1], *axes[2]};
  if (is_too_large(extent))
    throw volumes::InputError(fmt::format("--size: expected at most {} voxels in all, found {}",
                                          kMostVoxels, to_string(extent)));
  return extent;
}

volumes::Buffer read_file(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error))
    throw volumes::InputError(fmt::format("{}: expected an encoded file, found a folder", path));
  if (fs::exists(path, error) && !fs::is_regular_file(path, error))
    throw volumes::InputError(
        fmt::format("{}: expected an encoded file, found a pipe, a socket or a device", path));
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw volumes::InputError(
        fmt::format("{}: expected a readable file, found: {}", path, std::strerror(errno)));
  const std::uint64_t size = fs::file_size(path, error);
  if (error)
    throw volumes::InputError(
        fmt::format("{}: expected a regular file, found: {}", path, error.message()));
  volumes::Buffer bytes(size);
  if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
    throw volumes::InputError(
        fmt::format("{}: expected {} bytes, found {}", path, size, in.gcount()));
  }
  return bytes;
}

void write_file(const std::string& path, std::span<const std::byte> bytes) {
  volumes::OutputFile file(path);
  file.write(bytes);
  file.commit();
}

std::string json_text(const Row& value) {
  return value.dump(2, ' ', false, Row::error_handler_t::replace) + "\n";
}

void print_json(const Row& object) { fmt::print("{}", json_text(object)); }

int end_with_nothing(int exit_code, const std::string& why) {
  fmt::print(stderr, "cvrbench: {}\n", volumes::printable(why));
  return exit_code;
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
  for (const fs::path& folder : project_folders())
    places.push_back((folder / "configs" / "datasets").lexically_normal());
  std::error_code error;
  for (const fs::path& place : places) {
    if (fs::is_directory(place, error)) return place.string();
  }
  throw volumes::InputError(
      "expected a folder of data set descriptions (--datasets DIR), found none beside the "
      "configuration");
}

}  // namespace cvr::experiments::cli
