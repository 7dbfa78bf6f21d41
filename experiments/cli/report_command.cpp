// report: one HTML page of results folders, made by plots/report.py
#include "experiments/cli/report_command.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/config/project_folders.hpp"
#include "experiments/run/worker_process.hpp"
#include "experiments/tracking/history.hpp"
#include "volumes/io/file.hpp"

extern char** environ;

namespace cvr::experiments::cli {

namespace {

namespace fs = std::filesystem;

/// The exit code of a program, 127 where there is none of that name, 128 + signal where one ended
/// it. `quiet`: without its output.
int run_program(const std::vector<std::string>& words, bool quiet, InterruptWatch& watch) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (quiet) {
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  }
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  posix_spawnattr_setsigmask(&attributes, &watch.mask_before());
  pid_t child = -1;
  const int error =
      posix_spawnp(&child, arguments.front(), &actions, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error == ENOENT) return 127;
  if (error != 0)
    throw EnvironmentError(
        fmt::format("{}: cannot start: {}", words.front(), std::strerror(error)));
  watch.set_child(child);
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR)
      throw EnvironmentError(
          fmt::format("{}: cannot wait for it: {}", words.front(), std::strerror(errno)));
  }
  watch.set_child(0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// plots/report.py of the running program. Throws EnvironmentError.
std::string find_script() {
  std::vector<std::string> places;
  std::error_code error;
  for (const fs::path& folder : program_folders()) {
    places.push_back((folder / "plots" / "report.py").string());
    if (fs::is_regular_file(places.back(), error)) return places.back();
  }
  throw EnvironmentError(fmt::format("expected the report's program as {}, found none of them",
                                     fmt::join(places, " or ")));
}

/// A Python that has what the report needs: the first of the path, or Debian's. Throws
/// EnvironmentError.
std::string find_python(InterruptWatch& watch) {
  bool any = false;
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    const int code = run_program({python, "-c", "import jinja2, matplotlib, PIL"}, true, watch);
    if (code == 0) return python;
    any = any || code != 127;
  }
  throw EnvironmentError(any ? "expected a python3 with matplotlib and jinja2, found one without: "
                               "install the Debian packages python3-matplotlib and python3-jinja2"
                             : "expected python3, found none: install the Debian packages "
                               "python3-matplotlib and python3-jinja2");
}

/// What the report reads of results folders; the page may lie beside it.
std::vector<std::string> inputs_of(const ReportChoices& c) {
  std::vector<std::string> inputs;
  for (const fs::path folder : c.results) {
    for (const char* name : {"rows.jsonl", "codecs.json", "tables", "claims", "pictures"})
      inputs.push_back((folder / name).string());
  }
  return inputs;
}

}  // namespace

int report(const ReportChoices& c, const Environment& environment) {
  InterruptWatch watch;
  std::error_code error;
  for (const std::string& folder : c.results) {
    if (!fs::is_directory(folder, error))
      throw volumes::InputError(
          fmt::format("--results {}: expected a folder with rows.jsonl, found none", folder));
  }
  volumes::refuse_to_replace({c.output}, inputs_of(c));
  volumes::check_output(c.output);
  const std::string program = fs::read_symlink(environment.program, error).string();
  std::vector<std::string> words{
      "", "-B", find_script(), "-o", c.output, "--program", error ? environment.program : program};
  for (const std::string& folder : c.results) words.insert(words.end(), {"--results", folder});
  if (!c.figures.empty()) words.insert(words.end(), {"--figures", c.figures});
  if (!c.title.empty()) words.insert(words.end(), {"--title", c.title});
  if (fs::is_directory(c.store, error)) words.insert(words.end(), {"--store", c.store});
  words.front() = find_python(watch);
  const int code = run_program(words, false, watch);
  return code == kExitOk || code == kExitCheckFailed || code == kExitUsage ? code
                                                                           : kExitEnvironment;
}

void add_report_command(CLI::App& app, const Environment& environment, int& exit_code) {
  auto c = std::make_shared<ReportChoices>();
  c->store = history_folder(environment);
  auto* command = app.add_subcommand("report",
                                     "Makes one self-contained HTML page of results: summary, "
                                     "tables, claims, figures, images, provenance");
  command
      ->add_option("--results", c->results,
                   "folders with rows.jsonl; what a run left in tables/, claims/ and pictures/ "
                   "beside it is used too")
      ->required();
  command->add_option("-o,--output", c->output, "the page")->required();
  command->add_option("--figures", c->figures,
                      "folder for each figure as PDF and SVG, one column of a paper wide");
  command->add_option("--title", c->title, "heading of the page");
  command->add_option("--store", c->store, "folder of the history");
  command->callback([c, &environment, &exit_code] { exit_code = report(*c, environment); });
}

}  // namespace cvr::experiments::cli
