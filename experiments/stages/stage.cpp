#include "experiments/stages/stage.hpp"

#include <ctime>

namespace cvr::experiments {

namespace {

double seconds_of(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

// CLOCK_MONOTONIC is what std::chrono::steady_clock reads; CLOCK_PROCESS_CPUTIME_ID sums the
// process's threads.
Stopwatch::Stopwatch()
    : wall_(seconds_of(CLOCK_MONOTONIC)), cpu_(seconds_of(CLOCK_PROCESS_CPUTIME_ID)) {}

Sample Stopwatch::lap(std::string series, std::uint64_t count) const {
  const double cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
  return {std::move(series), seconds_of(CLOCK_MONOTONIC) - wall_, cpu - cpu_, count};
}

void fail_stage(const volumes::Error& error) {
  switch (error.code) {
    case volumes::ErrorCode::kUnsupported:
    case volumes::ErrorCode::kTooLarge:
      throw StageFailure(kUnsupported, error.message);
    case volumes::ErrorCode::kOutOfMemory:
      throw StageFailure(kOutOfMemory, error.message);
    default:
      throw StageFailure(kFailed, error.message);
  }
}

}  // namespace cvr::experiments
