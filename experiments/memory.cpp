#include "experiments/memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>

#include "experiments/provenance.hpp"

namespace cvr::experiments {

namespace {

/// The first number in a file; none where the file is missing or says "max".
std::optional<std::uint64_t> number_in(const std::string& path) {
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

}  // namespace

std::uint64_t usable_memory() {
  std::uint64_t size = 0, skipped = 0,
                data = 0;  // in pages: total, resident, shared, text, lib, data
  std::ifstream statm("/proc/self/statm");
  statm >> size >> skipped >> skipped >> skipped >> skipped >> data;
  const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::uint64_t usable = available_memory();
  usable = std::min(usable, left_of(RLIMIT_AS, size * page));
  usable = std::min(usable, left_of(RLIMIT_DATA, data * page));
  const auto most = number_in("/sys/fs/cgroup/memory.max");
  const auto used = number_in("/sys/fs/cgroup/memory.current");
  if (most && used) usable = std::min(usable, *most > *used ? *most - *used : 0);
  return usable;
}

}  // namespace cvr::experiments
