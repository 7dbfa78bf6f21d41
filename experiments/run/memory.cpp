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

constexpr std::uint64_t kNoLimit = ~std::uint64_t{0};

/// The files of one version's memory controller.
struct GroupFiles {
  const char* most;
  const char* used;
  const char* inactive;  ///< in memory.stat, of the group and those below it
};
constexpr GroupFiles kVersion1{"memory.limit_in_bytes", "memory.usage_in_bytes",
                               "total_inactive_file"};
constexpr GroupFiles kVersion2{"memory.max", "memory.current", "inactive_file"};

/// What the groups from mount/group up to the mount leave. The cache of files counts as used there,
/// but what of it was not read lately is given up first. In a container the group's path may be
/// that of the host; then the mount itself is the container's group.
std::uint64_t left_up_to(const fs::path& mount, const fs::path& group, const GroupFiles& files) {
  std::uint64_t left = kNoLimit;
  for (fs::path folder = group.empty() ? mount : mount / group;; folder = folder.parent_path()) {
    const auto most = number_in(folder / files.most);
    const auto used = number_in(folder / files.used);
    if (most && used) {
      std::ifstream statistics(folder / "memory.stat");
      std::uint64_t cached = 0, number = 0;
      for (std::string name; statistics >> name >> number;) {
        if (name == files.inactive) cached = number;
      }
      const std::uint64_t taken = *used - std::min(*used, cached);
      left = std::min(left, *most - std::min(*most, taken));
    }
    if (folder == mount || !folder.has_relative_path()) return left;
  }
}

}  // namespace

std::uint64_t left_of_control_groups(const fs::path& membership, const fs::path& mount) {
  std::ifstream groups(membership);
  std::uint64_t left = kNoLimit;
  // ID:CONTROLLERS:/GROUP; version 2 has the id 0 and no controllers.
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':'), second = line.find(":/", first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = ',' + line.substr(first + 1, second - first - 1) + ',';
    const fs::path group = line.substr(second + 2);
    if (line.starts_with("0::/")) left = std::min(left, left_up_to(mount, group, kVersion2));
    if (controllers.find(",memory,") != std::string::npos)
      left = std::min(left, left_up_to(mount / "memory", group, kVersion1));
  }
  return left;
}

std::uint64_t usable_memory() {
  // In pages: total, resident, shared, text, lib, data.
  std::uint64_t size = 0, skipped = 0, data = 0;
  std::ifstream statm("/proc/self/statm");
  statm >> size >> skipped >> skipped >> skipped >> skipped >> data;
  const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::uint64_t usable = available_memory();
  usable = std::min(usable, left_of(RLIMIT_AS, size * page));
  usable = std::min(usable, left_of(RLIMIT_DATA, data * page));
  return std::min(usable, left_of_control_groups("/proc/self/cgroup", "/sys/fs/cgroup"));
}

}  // namespace cvr::experiments
