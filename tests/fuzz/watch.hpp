// The promises that every piece of code under test keeps on bytes that nobody vouches for: it
// throws nothing, takes no more than seconds of this thread's own time (not of the clock's, which
// stands for the machine's other work too), and little memory.
#pragma once

#include <gtest/gtest.h>
#include <time.h>

#include "tests/fuzz/allocation_watch.hpp"

namespace cvr::fuzz {

inline constexpr double kMostSeconds = 20;

/// Eight times the file plus 256 MiB.
constexpr std::size_t most_bytes(std::size_t file) { return 8 * file + (std::size_t{256} << 20); }

inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Fails the test (fatally, for the function alone) unless the body keeps them for a file of that
/// size.
template <class Body>
void watch(std::size_t file, Body&& body) {
  const double begin = thread_seconds();
  start_watching();
  ASSERT_NO_THROW(body());
  const std::size_t held = most_bytes_held();
  if (counts_allocations()) {
    ASSERT_LE(held, most_bytes(file));
  }
  ASSERT_LE(thread_seconds() - begin, kMostSeconds);
}

}  // namespace cvr::fuzz
