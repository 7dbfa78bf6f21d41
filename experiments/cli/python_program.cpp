#include "experiments/cli/python_program.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "experiments/cli/commands.hpp"
#include "experiments/config/project_folders.hpp"
#include "experiments/run/worker_process.hpp"

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

/// The file in plots/ of the running program. Throws EnvironmentError.
std::string find_file(const std::string& name) {
  std::vector<std::string> places;
  std::error_code error;
  for (const fs::path& folder : program_folders()) {
    places.push_back((folder / "plots" / name).string());
    if (fs::is_regular_file(places.back(), error)) return places.back();
  }
  throw EnvironmentError(fmt::format("expected this command's program as {}, found none of them",
                                     fmt::join(places, " or ")));
}

/// The first of the path, or Debian's. Throws EnvironmentError.
std::string find_python(const std::vector<std::string>& modules, InterruptWatch& watch) {
  const std::string test = fmt::format("import sys, {}", fmt::join(modules, ", "));
  bool any = false;
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    const int code =
        run_program({python, "-c", modules.empty() ? "import sys" : test}, true, watch);
    if (code == 0) return python;
    any = any || code != 127;
  }
  throw EnvironmentError(
      any ? fmt::format("expected a python3 with {}, found one without: install the Debian "
                        "packages python3-matplotlib and python3-jinja2",
                        fmt::join(modules, ", "))
          : "expected python3, found none: install the Debian packages python3-matplotlib and "
            "python3-jinja2");
}

}  // namespace

std::string path_for_children(const std::string& program) {
  std::error_code error;
  const std::string file = fs::read_symlink(program, error).string();
  return error ? program : file;
}

int run_python(const PythonProgram& program, const std::vector<std::string>& arguments,
               InterruptWatch& watch) {
  std::vector<std::string> words{"", "-B", find_file(program.file)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.front() = find_python(program.modules, watch);
  const int code = run_program(words, false, watch);
  return code == kExitOk || code == kExitCheckFailed || code == kExitUsage ? code
                                                                           : kExitEnvironment;
}

}  // namespace cvr::experiments::cli
