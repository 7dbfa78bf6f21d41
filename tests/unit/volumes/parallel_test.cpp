// The pool behind parallel_for: which workers there are, what happens to exceptions, calls within
// calls and beside each other, processes that fork, and threads that cannot be started.
#include "volumes/parallel.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <ctime>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>
#include <vector>

#include "volumes/error.hpp"

namespace cvr::volumes {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  ///< limits of memory and threads after a fork are not for these
#else
constexpr bool kSanitized = false;
#endif

/// What a process of its own that runs `f` ends with: 0 where `f` gives true.
template <class F>
int in_child(F&& f) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(60);  // a hang is a failure, not a test that never ends
    ::_exit(f() ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  return status;
}

std::uint64_t sum_by(unsigned threads, std::uint64_t count) {
  std::vector<std::uint64_t> sums(threads);
  parallel_for(threads, count, [&](unsigned worker, std::uint64_t i) { sums[worker] += i; });
  return std::accumulate(sums.begin(), sums.end(), std::uint64_t{0});
}

TEST(ParallelFor, VisitsEveryIndexOnceAndRethrows) {
  for (const unsigned threads : {0u, 1u, 2u, 7u}) {
    std::vector<std::atomic<int>> visits(1000);
    parallel_for(threads, visits.size(), [&](unsigned worker, std::uint64_t i) {
      EXPECT_LT(worker, std::max(threads, 1u));
      ++visits[i];
    });
    for (const auto& n : visits) EXPECT_EQ(n, 1);
    EXPECT_THROW(parallel_for(threads, 10,
                              [](unsigned, std::uint64_t i) {
                                if (i == 3) throw InputError("x");
                              }),
                 InputError);
  }
}

TEST(ParallelFor, RunsInTheCallersThreadWhereOneIsEnough) {
  const auto here = std::this_thread::get_id();
  const auto each = [here](unsigned worker, std::uint64_t) {
    EXPECT_EQ(worker, 0u);
    EXPECT_EQ(std::this_thread::get_id(), here);
  };
  parallel_for(1, 100, each);
  parallel_for(8, 1, each);
  parallel_for(8, 0, [](unsigned, std::uint64_t) { ADD_FAILURE(); });
}

TEST(ParallelFor, NoTwoThreadsHaveOneWorkerNumber) {
  for (int call = 0; call < 200; ++call) {
    std::vector<std::atomic<int>> inside(4);
    parallel_for(4, 64, [&](unsigned worker, std::uint64_t) {
      EXPECT_EQ(inside.at(worker).fetch_add(1), 0);
      std::this_thread::yield();
      inside[worker].fetch_sub(1);
    });
  }
}

TEST(ParallelFor, UsesAsManyThreadsAsAskedForAtOnce) {
  std::atomic<unsigned> inside{0};
  parallel_for(5, 5, [&](unsigned, std::uint64_t) {
    ++inside;
    while (inside < 5) std::this_thread::yield();  // each index has a thread of its own
  });
  EXPECT_EQ(inside, 5u);
}

TEST(ParallelFor, KeepsItsThreads) {
  std::mutex mutex;
  std::set<std::thread::id> ids;
  for (int call = 0; call < 50; ++call) {
    std::atomic<unsigned> inside{0};
    parallel_for(2, 2, [&](unsigned, std::uint64_t) {
      ++inside;
      while (inside < 2) std::this_thread::yield();
      const std::scoped_lock lock(mutex);
      ids.insert(std::this_thread::get_id());
    });
  }
  EXPECT_LT(ids.size(), 20u);  // 51 where each call starts one
}

TEST(ParallelFor, CallsWithinCallsEnd) {
  std::atomic<std::uint64_t> sum{0};
  parallel_for(3, 20, [&](unsigned, std::uint64_t) {
    parallel_for(3, 20, [&](unsigned worker, std::uint64_t) {
      EXPECT_LT(worker, 3u);
      sum += sum_by(2, 10);
    });
  });
  EXPECT_EQ(sum, 20u * 20u * 45u);
}

TEST(ParallelFor, ExceptionsPassThroughCallsWithinCalls) {
  EXPECT_THROW(parallel_for(3, 20,
                            [](unsigned, std::uint64_t) {
                              parallel_for(3, 20, [](unsigned, std::uint64_t i) {
                                if (i == 11) throw InputError("x");
                              });
                            }),
               InputError);
  EXPECT_EQ(sum_by(3, 100), 4950u);
}

TEST(ParallelFor, CallsOfManyThreadsDoNotMix) {
  std::vector<std::jthread> callers;
  for (unsigned caller = 0; caller < 4; ++caller) {
    callers.emplace_back([] {
      for (std::uint64_t call = 0; call < 300; ++call)
        EXPECT_EQ(sum_by(3, call), call == 0 ? 0 : call * (call - 1) / 2);
    });
  }
}

TEST(ParallelFor, WaitingThreadsTakeNoTime) {
  sum_by(4, 1000);
  timespec before{}, after{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &before);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &after);
  const double seconds = static_cast<double>(after.tv_sec - before.tv_sec) +
                         1e-9 * static_cast<double>(after.tv_nsec - before.tv_nsec);
  EXPECT_LT(seconds, 0.1);
}

TEST(ParallelFor, AChildProcessHasThreadsOfItsOwn) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer allows no threads in a child";
  sum_by(4, 1000);
  for (int child = 0; child < 20; ++child) {
    // Whatever the pool does while the child is made.
    std::jthread busy([](const std::stop_token& stop) {
      while (!stop.stop_requested()) sum_by(3, 50);
    });
    EXPECT_EQ(in_child([] { return sum_by(4, 1000) == 499500; }), 0);
  }
  EXPECT_EQ(sum_by(4, 1000), 499500u);
}

TEST(ParallelFor, AProcessEndsWhileThreadsWork) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer allows no threads in a child";
  const int status = in_child([] {
    sum_by(4, 1000);
    std::thread([] {
      parallel_for(3, 3, [](unsigned, std::uint64_t) {
        std::this_thread::sleep_for(std::chrono::seconds(30));
      });
    }).detach();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::exit(0);  // with destructors and exit handlers
    return false;
  });
  EXPECT_EQ(status, 0);
}

TEST(ParallelFor, DoesWithoutThreadsThatCannotBeStarted) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's memory exceeds any limit";
  EXPECT_EQ(in_child([] {
              const rlimit space{std::uint64_t{1} << 20, std::uint64_t{1} << 20};
              ::setrlimit(RLIMIT_AS, &space);  // less than is in use: no stack can be mapped
              return sum_by(64, 1000) == 499500;
            }),
            0);
}

TEST(ParallelFor, SignalsThatEndAProgramAreNotForItsThreads) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    std::atomic<unsigned> inside{0}, blocked{0};
    parallel_for(3, 3, [&](unsigned worker, std::uint64_t) {
      ++inside;
      while (inside < 3) std::this_thread::yield();
      sigset_t mask;
      pthread_sigmask(SIG_BLOCK, nullptr, &mask);
      if (worker != 0 && sigismember(&mask, number) == 1) ++blocked;
    });
    EXPECT_EQ(blocked, 2u);
  }
}

}  // namespace
}  // namespace cvr::volumes
