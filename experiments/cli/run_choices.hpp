// What the commands that measure have in common: options, configurations, progress, signals.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "experiments/cli/app.hpp"
#include "experiments/run/runner.hpp"

namespace cvr::experiments::cli {

struct RunChoices {
  std::vector<std::string> configs, only, settings;
  std::string out, datasets, data, cache, device;
  bool resume = false, force = false;
};

/// --set, --datasets.
void add_config_options(CLI::App& command, RunChoices& choices);
/// --only, --data, --cache.
void add_data_options(CLI::App& command, RunChoices& choices);

/// "KEY=GLOB". Throws InputError.
Filter parse_filter(const std::vector<std::string>& only);
/// Throws InputError.
Config load(const RunChoices& choices, const std::string& path);
/// results/local/NAME of the first configuration unless `choices` names a folder.
std::string default_out(const RunChoices& choices);

/// Runs a configuration with progress on standard error. SIGINT, SIGTERM and SIGHUP end the
/// program, by the signal, after the workers have ended, the row files are whole, the scratch files
/// are gone, and a word on what `kept` holds; a second signal ends it at once, and the workers with
/// it. `redo` and `ignored_rows` as in RunOptions.
RunSummary measure(const Config& config, const RunChoices& choices,
                   const std::vector<Contender>& contenders, bool redo, const std::string& kept,
                   std::size_t ignored_rows = 0);
/// Prints the tables and claims of what was measured into a folder, leaves them there, and says how
/// many cells ended how. The exit code.
int finish_run(const std::vector<Config>& configs, const RunChoices& choices,
               const RunSummary& summary);
/// Clears the line of progress.
void end_progress();

/// The exit code of what was measured: 0 where a cell is ok or was done before and none has failed,
/// 1 where one failed, 3 where failures are the device's alone. Where no cell is ok a line on
/// standard error says why, and it is 1 where cells failed or this program supports none of them, 3
/// where data is missing. `rows_path`: of the rows just written.
int exit_code_of(const RunSummary& summary, const std::string& rows_path);
/// Whether any row is ok.
bool any_ok(const std::vector<Result>& rows);

/// Throws InputError where there are none.
std::vector<Result> rows_in(const std::string& folder);

}  // namespace cvr::experiments::cli
