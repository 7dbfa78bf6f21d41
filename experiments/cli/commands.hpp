// Each command group adds its commands to the application; a command that is given sets the exit
// code.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "codecs/codec.hpp"
#include "experiments/cli/app.hpp"
#include "experiments/config/datasets.hpp"
#include "experiments/results/rows.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments::cli {

inline constexpr int kExitOk = 0, kExitCheckFailed = 1, kExitUsage = 2, kExitEnvironment = 3;

void add_run_commands(CLI::App& app, const Environment& environment,
                      int& exit_code);  // run, plan, table, claims, worker
void add_tracking_commands(CLI::App& app, const Environment& environment,
                           int& exit_code);  // compare, ab, aa, baseline, history, export
void add_bench_command(CLI::App& app, const Environment& environment, int& exit_code);  // bench
void add_list_command(CLI::App& app, const Environment& environment, int& exit_code);   // list
void add_volume_commands(CLI::App& app, int& exit_code);      // generate, convert
void add_codec_commands(CLI::App& app, int& exit_code);       // encode, decode, validate
void add_inspection_commands(CLI::App& app, int& exit_code);  // inspect, at, error
void add_pack_commands(CLI::App& app, const Environment& environment,
                       int& exit_code);                  // pack, verify
void add_docs_command(CLI::App& app, int& exit_code);    // docs
void add_render_command(CLI::App& app, int& exit_code);  // render
void add_report_command(CLI::App& app, const Environment& environment, int& exit_code);  // report
void add_leaderboard_command(CLI::App& app, const Environment& environment,
                             int& exit_code);  // leaderboard

/// The object of each codec in the order of the registry, as 'list codecs --json' prints them; a run
/// leaves them in its folder as codecs.json.
Row describe_codecs();

/// "X,Y,Z" with positive integers. Throws InputError.
volumes::Extent parse_extent(const std::string& text);

/// Codec of an id and its parameters from NAME=VALUE texts. Throws InputError naming --codec or -p.
std::pair<const codecs::Codec*, codecs::Parameters> parse_codec(
    const std::string& id, const std::vector<std::string>& parameters);

/// The whole file. Throws InputError.
volumes::Buffer read_file(const std::string& path);
/// Writes under a temporary name and renames. Throws OutputError.
void write_file(const std::string& path, std::span<const std::byte> bytes);
/// One JSON value, indented, and a line end.
std::string json_text(const Row& value);
/// The same on standard output.
void print_json(const Row& object);

/// One line on standard error that says why a command that measures or judges has nothing to show.
/// Returns the exit code.
int end_with_nothing(int exit_code, const std::string& why);

/// "FILE: message" as an InputError.
[[noreturn]] void fail_on_file(const std::string& path, const volumes::Error& error);

/// The folder of data set descriptions: `given`, or the first that exists of datasets/ beside the
/// configuration or above it, configs/datasets below the current folder and that of the source
/// tree.
std::string find_catalogue(const std::string& given, const std::string& config_path);

}  // namespace cvr::experiments::cli
