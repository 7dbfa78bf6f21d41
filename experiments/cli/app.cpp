#include "experiments/cli/app.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <new>
#include <sstream>
#include <system_error>

#include "experiments/cli/commands.hpp"
#include "experiments/cli/standard_output.hpp"
#include "experiments/results/build_info.hpp"
#include "experiments/run/worker_process.hpp"
#include "gpu/vulkan/device.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace {

int complain(int exit_code, const std::string& text) {
  std::string line = text;
  for (char& c : line) c = c == '\n' ? ' ' : c;  // of messages of several lines
  fmt::print(stderr, "cvrbench: {}\n", volumes::printable(line));
  return exit_code;
}

std::string expected_command(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> names;
  for (const CLI::App* command :
       app.get_subcommands([](const CLI::App* a) { return !a->get_group().empty(); })) {
    names.push_back(command->get_name());
  }
  const std::string found = argc > 1 ? argv[1] : "";
  return fmt::format("expected one of the commands {}, found {}{} (see cvrbench --help)",
                     fmt::join(names, ", "), found.empty() ? "none" : "'" + found + "'",
                     volumes::did_you_mean(found, names));
}

/// Help and version, whose texts the parser makes.
int print_answer(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream text;
  const int exit_code = app.exit(error, text, text);
  fmt::print("{}", text.str());
  return exit_code;
}

/// The command without the last of its standard output. `lost`: why a part of that is lost already.
int run_command(int argc, char** argv, const Environment& environment, std::error_code& lost) {
  CLI::App app{"Measures how small, how fast and how exact compressed volumes are, and draws them.",
               "cvrbench"};
  app.set_version_flag(
      "--version", fmt::format("cvrbench {} ({})", build_info::kVersion, build_info::kRevision));
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 ok; 1 a check or a regression failed, every cell failed, or nothing could be "
      "judged; 2 usage, configuration or "
      "input; 3 environment: data, device, disk or memory are missing. Rates are percent of the "
      "original's bytes.");
  int exit_code = kExitOk;
  add_bench_command(app, environment, exit_code);
  add_run_commands(app, environment, exit_code);
  add_tracking_commands(app, environment, exit_code);
  add_list_command(app, environment, exit_code);
  add_volume_commands(app, exit_code);
  add_codec_commands(app, exit_code);
  add_inspection_commands(app, exit_code);
  add_render_command(app, exit_code);
  add_report_command(app, environment, exit_code);
  add_pack_commands(app, environment, exit_code);
  add_leaderboard_command(app, environment, exit_code);
  add_docs_command(app, exit_code);
  try {
    app.parse(argc, argv);
    return exit_code;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      try {
        return print_answer(app, error);
      } catch (const std::system_error& failure) {
        lost = failure.code();
        return kExitEnvironment;
      }
    }
    if (app.get_subcommands().empty())
      return complain(kExitUsage, expected_command(app, argc, argv));
    std::string command;
    for (const CLI::App* sub : app.get_subcommands()) command += " " + sub->get_name();
    return complain(kExitUsage, fmt::format("{} (see cvrbench{} --help)", error.what(), command));
  } catch (const volumes::InputError& error) {
    return complain(kExitUsage, error.what());
  } catch (const volumes::OutputError& error) {
    return complain(kExitEnvironment, error.what());
  } catch (const EnvironmentError& error) {
    return complain(kExitEnvironment, error.what());
  } catch (const gpu::DeviceError& error) {
    return complain(kExitEnvironment, error.what());
  } catch (const Row::exception& error) {
    return complain(
        kExitUsage,
        fmt::format("expected rows, figures or floors as this program writes them, found: {}",
                    error.what()));
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) != 0) {
      lost = error.code();
      return kExitEnvironment;
    }
    return complain(kExitEnvironment, error.what());
  } catch (const std::bad_alloc&) {
    return complain(kExitEnvironment, "not enough memory");
  } catch (const std::exception& error) {
    return complain(kExitEnvironment, error.what());
  }
}

}  // namespace

int run_command_line(int argc, char** argv, const Environment& environment) {
  std::error_code lost;
  const int exit_code = run_command(argc, argv, environment, lost);
  return finish_standard_output(exit_code, lost);
}

}  // namespace cvr::experiments::cli
