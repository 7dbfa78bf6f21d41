#include "experiments/stages/stage.hpp"

#include <cstdlib>
#include <ctime>

namespace cvr::experiments {

namespace {

double seconds_of(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// How many times as long the laps of a series are made to take:
/// CVRBENCH_TEST_SLOWER=SERIES=FACTOR, for tests of comparisons.
double slowness_of(std::string_view series) {
  static const std::string kSlower =
      std::getenv("CVRBENCH_TEST_SLOWER") == nullptr ? "" : std::getenv("CVRBENCH_TEST_SLOWER");
  const std::size_t equals = kSlower.find('=');
  return equals == std::string::npos || kSlower.substr(0, equals) != series
             ? 1
             : std::stod(kSlower.substr(equals + 1));
}

}  // namespace

// CLOCK_MONOTONIC is what std::chrono::steady_clock reads; CLOCK_PROCESS_CPUTIME_ID sums the
// process's threads.
Stopwatch::Stopwatch()
    : wall_(seconds_of(CLOCK_MONOTONIC)), cpu_(seconds_of(CLOCK_PROCESS_CPUTIME_ID)) {}

Sample Stopwatch::lap(std::string series, std::uint64_t count) const {
  if (const double slowness = slowness_of(series); slowness > 1) {
    const double end = wall_ + slowness * (seconds_of(CLOCK_MONOTONIC) - wall_);
    while (seconds_of(CLOCK_MONOTONIC) < end) continue;
  }
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
