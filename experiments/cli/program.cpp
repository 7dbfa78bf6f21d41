#include "experiments/cli/program.hpp"

#include <fcntl.h>
#include <signal.h>

#include <cstdlib>
#include <string>

#include "experiments/cli/app.hpp"

namespace cvr::experiments::cli {

namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// Takes the numbers 0 to 2 where the caller closed them, so that no file that is opened later gets
/// one and receives what is printed. What is written to a closed standard output then fails, as it
/// should; what is said on a closed standard error is lost.
void hold_standard_descriptors() {
  for (const int descriptor : {0, 1, 2}) {
    if (::fcntl(descriptor, F_GETFD) >= 0) continue;
    if (::open("/dev/null", descriptor == 2 ? O_WRONLY : O_RDONLY) != descriptor) std::_Exit(3);
  }
}

}  // namespace

int run_program(int argc, char** argv, StageHooks& hooks) {
  hold_standard_descriptors();
  ::signal(
      SIGXFSZ,
      SIG_IGN);  // a file that reaches the limit of its size (ulimit -f) is an error of writing, not the program's end
  Environment environment;
  environment.hooks = &hooks;
  environment.program = "/proc/self/exe";
  environment.data = variable("CVRBENCH_DATA");
  if (const std::string cache = variable("XDG_CACHE_HOME"); !cache.empty()) {
    environment.cache = cache + "/cvrbench";
  } else if (const std::string home = variable("HOME"); !home.empty()) {
    environment.cache = home + "/.cache/cvrbench";
  } else {
    environment.cache = ".cvrbench-cache";
  }
  if (const std::string data = variable("XDG_DATA_HOME"); !data.empty()) {
    environment.share = data + "/cvrbench";
  } else {
    const std::string home = variable("HOME");
    environment.share = (home.empty() ? "." : home) + "/.local/share/cvrbench";
  }
  return run_command_line(argc, argv, environment);
}

}  // namespace cvr::experiments::cli
