// The parent's end of a worker: starts this program anew with the hidden command `worker`, talks to it
// through pipes with deadlines, and learns how it ended.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

#include "experiments/rows.hpp"

namespace cvr::experiments {

/// The machine cannot do it: no process, no pipe. The command line ends with exit code 3.
class EnvironmentError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The first line that a program writes to its standard output when it is called with one argument. Throws EnvironmentError.
std::string first_line_of(const std::string& program, const std::string& argument);

struct WorkerEnd {
  int signal = 0;  ///< that ended it, 0 if it exited
  int exit_code = 0;
  std::uint64_t peak_bytes = 0;  ///< largest resident memory since the check
  std::string complaints;        ///< the last of what it wrote to standard error
};

class WorkerProcess {
 public:
  /// Throws EnvironmentError.
  explicit WorkerProcess(const std::string& program);
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  /// Runs it on one core from now on, of those that it may use: the n-th, counted round. Its threads that are there stay where they are.
  void move_to_core(std::size_t n);

  /// False when the worker is gone.
  bool send(const std::string& text);

  enum class Wait { kMessage, kTimeout, kEnd, kInterrupted };
  /// Waits for the next line. kInterrupted: a signal arrived.
  Wait receive(double timeout_seconds, Row& message);

  /// Closes its input and waits up to `grace_seconds`, then kills it. Once.
  WorkerEnd finish(double grace_seconds);
  bool killed() const { return killed_; }

 private:
  pid_t pid_ = -1;
  int to_ = -1, from_ = -1, complaints_ = -1;
  bool killed_ = false;
  std::string pending_;
};

}  // namespace cvr::experiments
