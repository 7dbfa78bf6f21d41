// The outputs of this process that have not got their final names yet, so that a program that a
// signal ends can remove them.
#pragma once

#include <mutex>
#include <string>

namespace cvr::volumes {

/// While one lives, no other thread makes, renames or removes an unfinished output, and none is
/// abandoned: a name is listed from the moment at which it exists until it has been renamed or
/// removed. Short-lived; a thread holds at most one.
class UnfinishedOutputs {
 public:
  UnfinishedOutputs();
  void add(const std::string& path);
  void remove(const std::string& path);

 private:
  std::lock_guard<std::mutex> lock_;
};

/// Removes every unfinished file and folder of this process. From then on none can be begun or get
/// its final name: threads that try wait forever. For a program that is about to end by a signal;
/// not for signal handlers, which may not wait for other threads.
void abandon_outputs();

}  // namespace cvr::volumes
