#include "experiments/results/provenance.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gnu/libc-version.h>
#include <sys/utsname.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>
#include <vector>

#include "codecs/library_versions.hpp"
#include "experiments/results/build_info.hpp"

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

std::string first_line_in(const char* path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

/// What vector code and bit manipulation may depend on, here and in the libraries, which choose at
/// run time; names of /proc/cpuinfo.
constexpr std::array kCpuFeatures{"sse4_2",     "popcnt", "avx",  "avx2",    "fma",
                                  "f16c",       "bmi1",   "bmi2", "avx512f", "avx512bw",
                                  "avx512vbmi", "asimd",  "sve"};

const std::vector<std::string> kCompiledFeatures{
#ifdef __SSE4_2__
    "sse4_2",
#endif
#ifdef __POPCNT__
    "popcnt",
#endif
#ifdef __AVX__
    "avx",
#endif
#ifdef __AVX2__
    "avx2",
#endif
#ifdef __FMA__
    "fma",
#endif
#ifdef __F16C__
    "f16c",
#endif
#ifdef __BMI__
    "bmi1",
#endif
#ifdef __BMI2__
    "bmi2",
#endif
#ifdef __AVX512F__
    "avx512f",
#endif
#ifdef __AVX512BW__
    "avx512bw",
#endif
#ifdef __AVX512VBMI__
    "avx512vbmi",
#endif
#ifdef __ARM_NEON
    "asimd",
#endif
#ifdef __ARM_FEATURE_SVE
    "sve",
#endif
};

Provenance::CpuFeatures describe_cpu_features() {
  std::istringstream words(value_in("/proc/cpuinfo", "flags", ':') + " " +
                           value_in("/proc/cpuinfo", "Features", ':'));
  std::set<std::string> present;
  for (std::string word; words >> word;) present.insert(word);
  Provenance::CpuFeatures features;
  features.compiled = kCompiledFeatures;
  for (const char* name : kCpuFeatures) {
    if (present.contains(name)) features.present.emplace_back(name);
  }
  return features;
}

/// "on", "off" or "unknown".
std::string turbo() {
  if (const std::string off = first_line_in("/sys/devices/system/cpu/intel_pstate/no_turbo");
      !off.empty())
    return off == "0" ? "on" : "off";
  const std::string on = first_line_in("/sys/devices/system/cpu/cpufreq/boost");
  return on.empty() ? "unknown" : on == "0" ? "off" : "on";
}

/// The governors of all cores, each once.
std::string governors() {
  std::set<std::string> found;
  for (unsigned core = 0; core < std::thread::hardware_concurrency(); ++core) {
    const std::string governor = first_line_in(
        fmt::format("/sys/devices/system/cpu/cpu{}/cpufreq/scaling_governor", core).c_str());
    if (!governor.empty()) found.insert(governor);
  }
  return or_unknown(fmt::format("{}", fmt::join(found, ", ")));
}

/// "madvise" of "always [madvise] never".
std::string huge_pages() {
  const std::string choices = first_line_in("/sys/kernel/mm/transparent_hugepage/enabled");
  const std::size_t from = choices.find('['), to = choices.find(']');
  return from == std::string::npos || to == std::string::npos
             ? "unknown"
             : choices.substr(from + 1, to - from - 1);
}

}  // namespace

std::string utc_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

std::uint64_t available_memory() { return meminfo("MemAvailable"); }

Provenance describe_machine_and_build() {
  utsname system{};
  uname(&system);
  Provenance p;
  p.harness = build_info::kVersion;
  p.revision = build_info::kRevision;
  p.compiler = build_info::kCompiler;
  p.flags = build_info::kFlags;
  p.build_type = build_info::kBuildType;
  p.cpu = or_unknown(value_in("/proc/cpuinfo", "model name", ':'));
  p.cores = std::thread::hardware_concurrency();
  p.memory_bytes = meminfo("MemTotal");
  p.kernel = fmt::format("{} {}", system.sysname, system.release);
  p.os = or_unknown(value_in("/etc/os-release", "PRETTY_NAME", '='));
  const std::string machine = fmt::format("{}|{}|{}", Row(p.cpu).dump(), p.cores, p.memory_bytes);
  p.machine = fmt::format("{:016x}", XXH3_64bits(machine.data(), machine.size()));
  p.libc = fmt::format("glibc {}", gnu_get_libc_version());
  p.libraries.emplace();
  for (const auto& [name, version] : codecs::library_versions()) (*p.libraries)[name] = version;
  p.cpu_features = describe_cpu_features();
  p.governor = governors();
  p.turbo = turbo();
  p.huge_pages = huge_pages();
  return p;
}

std::string what_times_depend_on(const Provenance& p) {
  Provenance fixed = p;
  for (auto* setting : {&fixed.governor, &fixed.turbo, &fixed.huge_pages}) setting->reset();
  return to_json(fixed).dump(-1, ' ', false, Row::error_handler_t::replace);
}

std::string hardware_line(const Provenance& p) {
  const double gib = static_cast<double>(p.memory_bytes) / (1 << 30);
  return fmt::format("{}, {} cores, {:.0f} GiB, {}, {}; {} ({}), revision {}", p.cpu, p.cores, gib,
                     p.kernel, p.os, p.compiler, p.flags, p.revision);
}

}  // namespace cvr::experiments
