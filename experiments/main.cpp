// The program: what the environment tells, then the command line.
#include <cstdlib>
#include <string>

#include "experiments/cli/app.hpp"

namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

int main(int argc, char** argv) {
  cvr::experiments::cli::Environment environment;
  environment.program = "/proc/self/exe";
  environment.data = variable("CVRBENCH_DATA");
  if (const std::string cache = variable("XDG_CACHE_HOME"); !cache.empty()) {
    environment.cache = cache + "/cvrbench";
  } else if (const std::string home = variable("HOME"); !home.empty()) {
    environment.cache = home + "/.cache/cvrbench";
  } else {
    environment.cache = ".cvrbench-cache";
  }
  return cvr::experiments::cli::run_command_line(argc, argv, environment);
}
