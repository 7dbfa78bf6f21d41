// What a command that writes does on Ctrl-C: nothing unfinished stays behind.
#pragma once

#include <signal.h>

#include <atomic>
#include <thread>

namespace cvr::experiments::cli {

/// While one lives, SIGINT, SIGTERM and SIGHUP end the program only after its unfinished outputs
/// are removed, and by the same signal: a shell sees 130, 143 or 129. Signals that the program was
/// started with ignored (nohup) stay so. Removing files is more than a signal handler may do, so a
/// thread waits for the signals, which all threads that start later do not take; commands make one
/// before they start others. Not for commands that end their work in order when a signal comes
/// (run).
class InterruptWatch {
 public:
  InterruptWatch();
  /// Where a signal has arrived it does not return.
  ~InterruptWatch();
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  /// A process that is ended by SIGTERM and waited for before this one ends; 0: none.
  void set_child(pid_t child) { child_ = child; }
  /// The signals that were blocked before, for children.
  const sigset_t& mask_before() const { return before_; }

 private:
  void watch();
  [[noreturn]] void end_by(int signal_number);

  sigset_t watched_, before_;
  std::atomic<pid_t> child_{0};
  int signals_ = -1, stop_ = -1;
  std::thread thread_;
};

}  // namespace cvr::experiments::cli
