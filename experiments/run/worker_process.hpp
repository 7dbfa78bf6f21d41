// The parent's end of a worker: starts this program anew with the hidden command `worker`, talks to
// it through pipes with deadlines, and learns how it ended.
//
// Whatever a worker does, its parent goes on: answers and what it writes to standard error are
// bounded, it may use so much processor time and write files so large as it is told, leaves no core
// dump, and dies with its parent. It leads a process group of its own, so a terminal's signals
// reach the parent alone, and processes that it started end with it.
#pragma once

#include <sys/types.h>

#include <csignal>
#include <cstdint>
#include <optional>
#include <string>

#include "experiments/results/rows.hpp"

namespace cvr::experiments {

/// The machine cannot do it: no process, no pipe. The command line ends with exit code 3.
class EnvironmentError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The first line that a program writes to its standard output when it is called with one argument.
/// Throws EnvironmentError.
std::string first_line_of(const std::string& program, const std::string& argument);

/// Of the system for one worker. What it may allocate it limits itself (worker.cpp).
struct WorkerLimits {
  std::uint64_t cpu_seconds = 0;  ///< of all its threads together; 0: no limit
  std::uint64_t file_bytes =
      0;  ///< of a file that it writes; writing beyond fails in the worker; 0: no limit
};

inline constexpr double kGrace = 5;  ///< seconds for a worker to free its memory and end

struct WorkerEnd {
  int signal = 0;  ///< that ended it, 0 if it exited
  int exit_code = 0;
  std::uint64_t peak_bytes = 0;  ///< largest resident memory since the check
  std::string
      complaints;  ///< the last 500 bytes that it wrote to standard error, control characters made visible
};

class WorkerProcess {
 public:
  /// Throws EnvironmentError.
  explicit WorkerProcess(const std::string& program, const WorkerLimits& limits = {});
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  /// Runs it on one core from now on, of those that it may use: the n-th, counted round. Its
  /// threads that are there stay where they are.
  void move_to_core(std::size_t n);

  /// False when the worker is gone.
  bool send(const std::string& text);

  enum class Wait : std::uint8_t { kMessage, kTimeout, kEnd, kInterrupted, kNoAnswer };
  /// Waits for the next line. kInterrupted: `interrupted` was set, at most a fifth of a second ago.
  /// kNoAnswer: what came is no JSON object, or longer than any answer; `said` is its beginning
  /// then.
  Wait receive(double timeout_seconds, Row& message,
               const volatile std::sig_atomic_t* interrupted = nullptr);
  const std::string& said() const { return said_; }

  /// Closes its input and waits up to `grace_seconds`, then kills it. Once.
  WorkerEnd finish(double grace_seconds);
  bool killed() const { return killed_; }

 private:
  void drain_complaints();
  Wait take_answer(std::size_t end, Row& message);

  pid_t pid_ = -1;
  int to_ = -1, from_ = -1, complaints_from_ = -1;
  bool killed_ = false;
  std::string pending_, said_, complaints_;
  std::size_t searched_ = 0;  ///< bytes of pending_ without a line end
};

}  // namespace cvr::experiments
