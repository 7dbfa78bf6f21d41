#include "experiments/provenance.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>
#include <xxhash.h>

#include <ctime>
#include <fstream>
#include <thread>

#include "experiments/build_info.hpp"

namespace cvr::experiments {

namespace {

/// The value of the first "key<separator>value" line of a file, trimmed of blanks and quotes.
std::string value_in(const char* path, std::string_view key, char separator) {
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    const std::size_t split = line.find(separator);
    if (split == std::string::npos || line.compare(0, key.size(), key) != 0) continue;
    const std::size_t first = line.find_first_not_of(" \t\"", split + 1);
    const std::size_t last = line.find_last_not_of(" \t\"");
    return first == std::string::npos ? "" : line.substr(first, last - first + 1);
  }
  return "";
}

std::uint64_t meminfo(std::string_view key) {
  const std::string text = value_in("/proc/meminfo", key, ':');
  return text.empty() ? 0 : std::stoull(text) * 1024;
}

std::string or_unknown(std::string text) { return text.empty() ? "unknown" : text; }

}  // namespace

std::string utc_now() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

std::uint64_t available_memory() { return meminfo("MemAvailable"); }

Row describe_machine_and_build() {
  utsname system{};
  uname(&system);
  Row p;
  p["harness"] = build_info::kVersion;
  p["revision"] = build_info::kRevision;
  p["compiler"] = build_info::kCompiler;
  p["flags"] = build_info::kFlags;
  p["build_type"] = build_info::kBuildType;
  p["cpu"] = or_unknown(value_in("/proc/cpuinfo", "model name", ':'));
  p["cores"] = std::thread::hardware_concurrency();
  p["memory_bytes"] = meminfo("MemTotal");
  p["kernel"] = fmt::format("{} {}", system.sysname, system.release);
  p["os"] = or_unknown(value_in("/etc/os-release", "PRETTY_NAME", '='));
  const std::string machine =
      fmt::format("{}|{}|{}", p["cpu"].dump(), p["cores"].dump(), p["memory_bytes"].dump());
  p["machine"] = fmt::format("{:016x}", XXH3_64bits(machine.data(), machine.size()));
  return p;
}

std::string hardware_line(const Row& p) {
  const double gib = p.value("memory_bytes", 0.0) / (1 << 30);
  return fmt::format("{}, {} cores, {:.0f} GiB, {}, {}; {} ({}), revision {}", p.value("cpu", "unknown CPU"),
                     p.value("cores", 0), gib, p.value("kernel", "unknown kernel"),
                     p.value("os", "unknown system"), p.value("compiler", "unknown compiler"),
                     p.value("flags", ""), p.value("revision", "unknown"));
}

}  // namespace cvr::experiments
