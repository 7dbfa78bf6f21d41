#include "experiments/run/memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "experiments/results/provenance.hpp"

namespace cvr::experiments {

namespace {

namespace fs = std::filesystem;

/// The first number in a file; none where the file is missing or says "max".
std::optional<std::uint64_t> number_in(const fs::path& path) {
  std::ifstream in(path);
  std::uint64_t number = 0;
  if (!(in >> number)) return std::nullopt;
  return number;
}

/// What a limit leaves; everything where there is none.
std::uint64_t left_of(int resource, std::uint64_t used) {
  rlimit limit{};
  if (getrlimit(static_cast<__rlimit_resource_t>(resource), &limit) != 0 ||
      limit.rlim_cur == RLIM_INFINITY)
    return ~std::uint64_t{0};
  return limit.rlim_cur > used ? limit.rlim_cur - used : 0;
}

/// What the control groups (version 2) of this process leave, its own and those above. The cache of
/// files counts as used there, but what of it was not read lately is given up first.
std::uint64_t left_of_control_groups() {
  std::ifstream groups("/proc/self/cgroup");
  std::string line;
  fs::path own;
  while (std::getline(groups, line)) {
    if (line.starts_with("0::/")) own = line.substr(4);
  }
  std::uint64_t left = ~std::uint64_t{0};
  for (fs::path folder = "/sys/fs/cgroup" / own;; folder = folder.parent_path()) {
    const auto most = number_in(folder / "memory.max");
    const auto used = number_in(folder / "memory.current");
    if (most && used) {
      std::ifstream statistics(folder / "memory.stat");
      std::uint64_t cached = 0, number = 0;
      for (std::string name; statistics >> name >> number;) {
        if (name == "inactive_file") cached = number;
      }
      const std::uint64_t taken = *used - std::min(*used, cached);
      left = std::min(left, *most - std::min(*most, taken));
    }
    if (folder == "/sys/fs/cgroup" || !folder.has_relative_path()) return left;
  }
}

}  // namespace

std::uint64_t usable_memory() {
  // In pages: total, resident, shared, text, lib, data.
  std::uint64_t size = 0, skipped = 0, data = 0;
  std::ifstream statm("/proc/self/statm");
  statm >> size >> skipped >> skipped >> skipped >> skipped >> data;
  const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::uint64_t usable = available_memory();
  usable = std::min(usable, left_of(RLIMIT_AS, size * page));
  usable = std::min(usable, left_of(RLIMIT_DATA, data * page));
  return std::min(usable, left_of_control_groups());
}

}  // namespace cvr::experiments
