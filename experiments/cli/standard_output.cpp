#include "experiments/cli/standard_output.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "experiments/cli/commands.hpp"

namespace cvr::experiments::cli {

namespace {

/// Some file systems tell of a full disk only when a file is closed; a second descriptor lets it be
/// closed and kept.
bool closes(int descriptor) {
  const int copy = ::dup(descriptor);
  return copy >= 0 && ::close(copy) == 0;
}

/// Why not all of standard output has arrived; no error where it has. A program that printed
/// nothing has lost nothing, even where the descriptor is closed.
std::error_code flush_standard_output() {
  const bool failed_before = std::ferror(stdout) != 0;
  if (std::fflush(stdout) != 0) return {errno, std::generic_category()};
  if (failed_before) return {EIO, std::generic_category()};
  if (!closes(STDOUT_FILENO) && errno != EBADF) return {errno, std::generic_category()};
  return {};
}

}  // namespace

int finish_standard_output(int exit_code, std::error_code lost) {
  const std::error_code reason = lost ? lost : flush_standard_output();
  if (!reason) return exit_code;
  if (reason == std::errc::broken_pipe) return 128 + SIGPIPE;
  const std::string text =
      reason == std::errc::bad_file_descriptor ? "it is closed" : reason.message();
  fmt::print(stderr, "cvrbench: standard output: cannot write: {}\n", text);
  return kExitEnvironment;
}

}  // namespace cvr::experiments::cli
