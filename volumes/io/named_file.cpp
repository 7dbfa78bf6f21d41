#include "volumes/io/named_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "volumes/io/format.hpp"

namespace cvr::volumes {

namespace {

namespace fs = std::filesystem;

bool lies_below(const fs::path& path, const fs::path& folder) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return end == folder.end();
}

}  // namespace

std::string named_file(const std::string& file, std::string_view position, std::string_view name,
                       const OpenOptions& options) {
  const fs::path target = fs::path(file).parent_path() / fs::path(name);
  if (options.allow_external) return target.string();
  const fs::path real = fs::weakly_canonical(fs::absolute(target));
  // A file reached through a symbolic link has the folder of the link and that of the file itself.
  const fs::path linked = fs::weakly_canonical(fs::absolute(file).parent_path());
  const fs::path own = fs::weakly_canonical(fs::absolute(file)).parent_path();
  if (lies_below(real, linked) || lies_below(real, own)) return target.string();
  throw_input_error(file, position,
                    fmt::format("a file in the volume's own folder {} (or --allow-external, "
                                "allow_external in a configuration)",
                                linked.string()),
                    fmt::format("'{}', which is {}", name, real.string()));
}

}  // namespace cvr::volumes
