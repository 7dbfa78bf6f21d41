#include "experiments/cli/run_choices.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "experiments/cli/commands.hpp"
#include "experiments/config/table_spec.hpp"
#include "experiments/config/yaml_reader.hpp"
#include "experiments/run/load_config.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace {

namespace fs = std::filesystem;

volatile std::sig_atomic_t interrupted = 0;  ///< the signal
timespec first_signal;

/// A signal that was sent twice at once, to the process and to its group, as timeout(1) does,
/// counts once.
constexpr double kOneSignal = 0.5;  // seconds

extern "C" void note_interrupt(int signal_number) {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (interrupted == 0) {
    first_signal = now;
    interrupted = signal_number;
    return;
  }
  const double passed = static_cast<double>(now.tv_sec - first_signal.tv_sec) +
                        1e-9 * static_cast<double>(now.tv_nsec - first_signal.tv_nsec);
  if (passed < kOneSignal) return;
  signal(signal_number,
         SIG_DFL);  // its workers are killed by the system, as always when this process ends
  raise(signal_number);
}

/// Signals as a run takes them; afterwards as before.
class RunSignals {
 public:
  RunSignals() {
    for (Former& one : former_) {
      struct sigaction action {};
      action.sa_handler = one.number == SIGPIPE || one.number == SIGXFSZ ? SIG_IGN : note_interrupt;
      sigaction(one.number, nullptr, &one.action);
      // What is ignored, as under nohup, stays so.
      if (one.action.sa_handler != SIG_IGN) sigaction(one.number, &action, nullptr);
    }
  }
  ~RunSignals() {
    for (const Former& one : former_) sigaction(one.number, &one.action, nullptr);
  }
  RunSignals(const RunSignals&) = delete;
  RunSignals& operator=(const RunSignals&) = delete;

 private:
  struct Former {
    int number;
    struct sigaction action {};
  };
  /// A file that reaches the limit for its size, and a worker that is gone, are errors of the
  /// write.
  std::array<Former, 5> former_{{{SIGINT}, {SIGTERM}, {SIGHUP}, {SIGPIPE}, {SIGXFSZ}}};
};

/// "45 s", "3 min", "2 h 5 min".
std::string duration_text(double seconds) {
  const auto minutes = static_cast<std::uint64_t>(seconds / 60 + 0.5);
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  return minutes < 60 ? fmt::format("{} min", minutes)
                      : fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

void show_progress(const Progress& progress) {
  if (isatty(STDERR_FILENO) == 0) {
    if (progress.cell_ended || progress.text.find(": preparing ") != std::string::npos) {
      fmt::print(stderr, "[{}/{}] {}\n", progress.done, progress.total,
                 volumes::printable(progress.text));
    }
    return;
  }
  constexpr std::size_t kWidth = 24;
  const std::size_t filled = progress.total == 0 ? kWidth : kWidth * progress.done / progress.total;
  const std::string left =
      progress.seconds_left > 0 ? ", about " + duration_text(progress.seconds_left) + " left" : "";
  fmt::print(stderr, "\r\x1b[K[{:#<{}}{:-<{}}] {}/{}{} {:.90}", "", filled, "", kWidth - filled,
             progress.done, progress.total, left, volumes::printable(progress.text));
  std::fflush(stderr);
}

}  // namespace

void add_config_options(CLI::App& command, RunChoices& c) {
  command
      .add_option(
          "--set", c.settings,
          "KEY=VALUE, in place of the file's: a top-level key (scale=1), a key of blocks in every "
          "block that may have it (frames=100), or a path (matrix.*.size=1920,1080)")
      ->allow_extra_args(false);
  command.add_option(
      "--datasets", c.datasets,
      "folder of data set descriptions (default: datasets beside the configuration or above)");
}

void add_data_options(CLI::App& command, RunChoices& c) {
  command
      .add_option("--only", c.only,
                  "KEY=GLOB: dataset, codec, stage, threads, a parameter, or of images scene, "
                  "access_mode, shading ..; or key, as a row names its cell; the same key twice "
                  "means either")
      ->allow_extra_args(false);
  command.add_option(
      "--data", c.data,
      "folder that ${CVRBENCH_DATA} stands for (default: that environment variable)");
  command.add_option(
      "--cache", c.cache,
      "folder for raw copies of data sets (default: cvrbench in the user's cache folder)");
}

Filter parse_filter(const std::vector<std::string>& only) {
  Filter filter;
  for (const std::string& text : only) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw volumes::InputError(fmt::format(
          "--only {}: expected KEY=GLOB with dataset, codec, stage, threads, a parameter, or of "
          "images scene, access_mode, shading ..",
          text));
    }
    auto keys = line_labels();
    keys.insert(keys.end(), {"stage", "key"});
    const std::string key(current_name(text.substr(0, equals)));
    if (std::ranges::find(keys, key) == keys.end())
      throw volumes::InputError(fmt::format("--only {}: expected one of the keys {}, found '{}'{}",
                                            text, fmt::join(keys, ", "), key,
                                            did_you_mean(key, keys)));
    filter.only.emplace_back(key, text.substr(equals + 1));
  }
  return filter;
}

Config load(const RunChoices& choices, const std::string& path) {
  Config config = load_config(path, Catalogue::from_folder(find_catalogue(choices.datasets, path)),
                              choices.settings);
  if (!choices.device.empty()) choose_device(config, choices.device);
  return config;
}

std::string default_out(const RunChoices& choices) {
  return choices.out.empty()
             ? (fs::path("results/local") / fs::path(choices.configs.front()).stem()).string()
             : choices.out;
}

RunSummary measure(const Config& config, const RunChoices& choices,
                   const std::vector<Contender>& contenders, bool redo, const std::string& kept,
                   std::size_t ignored_rows) {
  RunOptions options;
  options.contenders = contenders;
  options.places = {choices.data, choices.cache};
  options.filter = parse_filter(choices.only);
  options.redo = redo;
  options.ignored_rows = ignored_rows;
  options.progress = show_progress;
  options.interrupted = &interrupted;
  RunSummary summary;
  {
    const RunSignals signals;
    summary = run_config(config, options);
  }
  if (summary.total == 0)
    throw volumes::InputError(
        fmt::format("{}: expected cells that --only {} keeps, found none of {}", config.path,
                    fmt::join(choices.only, " --only "), config.cells.size()));
  if (summary.interrupted) {
    fmt::print(stderr, "\ncvrbench: interrupted; {}\n", kept);
    const int number = interrupted;
    signal(number, SIG_DFL);
    raise(number);
  }
  return summary;
}

void end_progress() {
  if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r\x1b[K");
}

int exit_code_of(const RunSummary& summary, const std::string& rows_path) {
  const auto count = [&](std::string_view status) {
    const auto found = summary.by_status.find(std::string(status));
    return found == summary.by_status.end() ? std::size_t{0} : found->second;
  };
  const std::size_t failed = count(kFailed);
  const int of_failures =
      failed > summary.environment_failures ? kExitCheckFailed : kExitEnvironment;
  if (count(kOk) + summary.skipped > 0) return failed == 0 ? kExitOk : of_failures;
  std::string counts;
  for (const auto& [status, number] : summary.by_status)
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", number, status);
  const std::size_t tried = failed + count(kTimeout) + count(kOutOfMemory);
  const int code = failed > 0 && tried == failed           ? of_failures
                   : tried > 0 || count(kDataMissing) == 0 ? kExitCheckFailed
                                                           : kExitEnvironment;
  return end_with_nothing(
      code,
      fmt::format("nothing was measured: no cell is ok ({}); the last one: {}; {} tells of each",
                  counts, summary.last_reason.empty() ? "no reason given" : summary.last_reason,
                  rows_path));
}

bool any_ok(const std::vector<Result>& rows) { return std::ranges::any_of(rows, &Result::is_ok); }

std::vector<Result> rows_in(const std::string& folder) {
  const std::string path = (fs::path(folder) / "rows.jsonl").string();
  if (!fs::exists(path) && !fs::exists(path + std::string(kCompressedEnding)))
    throw volumes::InputError(fmt::format(
        "{}: expected the rows of a run, found no such file: 'run' writes it with --out {}", path,
        folder));
  return load_rows(path);
}

}  // namespace cvr::experiments::cli
