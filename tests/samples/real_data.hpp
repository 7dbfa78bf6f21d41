// Tests on real volumes: what they do where the volumes are missing.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

/// Ends a test that lacks a file of CVRBENCH_DATA: it is skipped, or fails where CVRBENCH_REQUIRE_DATA
/// is set, as by `./check -L data`.
#define CVR_SKIP_UNLESS(there, reason)                          \
  if (there) {                                                  \
  } else if (std::getenv("CVRBENCH_REQUIRE_DATA") != nullptr) { \
    FAIL() << reason;                                           \
  } else                                                        \
    GTEST_SKIP() << reason
