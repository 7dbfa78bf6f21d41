// One pool of threads for the whole process, which grows to what its calls ask for at a time.
//
// A call of parallel_for is a loop on its caller's stack. The caller puts it on a list, wakes two
// threads, of which each wakes two more as long as helpers are missing, and works on the loop
// itself; when the indices are used up it takes the loop off the list and waits only for those that
// have joined it. So a thread that wakes late costs nothing, and a call within a body makes
// progress even where no other thread is free.
//
// Threads wait on a condition variable and are never joined: the pool is not destroyed, so the
// process may end while they wait or while a body runs. A child made by fork() has none of these
// threads, and begins with an empty pool. A thread that cannot be started, for want of memory under
// a limit for instance, is done without.
#include "volumes/parallel.hpp"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <csignal>
#include <cstddef>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>

namespace cvr::volumes {

namespace {

using Body = std::function<void(unsigned, std::uint64_t)>;

/// One call. What is neither const nor atomic is guarded by the pool's mutex, but for `failure`,
/// which has its own.
struct Loop {
  Loop(std::uint64_t indices, unsigned helpers, const Body& each)
      : count(indices), body(each), missing(helpers) {}
  void work(unsigned worker) {
    try {
      for (std::uint64_t i = next++; i < count; i = next++) body(worker, i);
    } catch (...) {
      const std::scoped_lock lock(failure_mutex);
      if (!failure) failure = std::current_exception();
      next = count;
    }
  }

  const std::uint64_t count;
  const Body& body;
  std::atomic<std::uint64_t> next{0};
  std::mutex failure_mutex;
  std::exception_ptr failure;
  Loop* below = nullptr;     ///< on the list of loops that want helpers
  unsigned missing;          ///< helpers that have not joined; 0: not on the list
  unsigned next_worker = 1;  ///< 0 is the caller
  unsigned helping = 0;
  std::condition_variable left;  ///< the last helper has
};

class Pool {
 public:
  void run(Loop& loop) {
    {
      const std::scoped_lock lock(mutex_);
      loop.below = wanting_;
      wanting_ = &loop;
      missing_ += loop.missing;
      start_threads();
    }
    wake();
    loop.work(0);
    std::unique_lock lock(mutex_);
    take_off(loop);
    loop.left.wait(lock, [&loop] { return loop.helping == 0; });
  }

 private:
  /// Until there is a free one for each helper that is missing.
  void start_threads() {
    if (threads_ - busy_ >= missing_) return;
    // Signals that end a program are for threads that know what to do about them.
    sigset_t ends, before;
    sigemptyset(&ends);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) sigaddset(&ends, signal);
    pthread_sigmask(SIG_BLOCK, &ends, &before);
    try {
      for (; threads_ - busy_ < missing_; ++threads_) std::thread([this] { serve(); }).detach();
    } catch (const std::system_error&) {  // fewer threads then
    } catch (const std::bad_alloc&) {
    }
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }

  void wake() {
    work_.notify_one();
    work_.notify_one();
  }

  void serve() {
    std::unique_lock lock(mutex_);
    while (true) {
      work_.wait(lock, [this] { return wanting_ != nullptr; });
      Loop& loop = *wanting_;
      const unsigned worker = loop.next_worker++;
      if (--loop.missing == 0) wanting_ = loop.below;
      --missing_;
      ++loop.helping;
      ++busy_;
      const bool more = wanting_ != nullptr;
      lock.unlock();
      if (more) wake();
      loop.work(worker);
      lock.lock();
      --busy_;
      // Notified under the mutex, without which the caller does not go on: the loop still exists.
      if (--loop.helping == 0) loop.left.notify_one();
    }
  }

  void take_off(Loop& loop) {
    if (loop.missing == 0) return;
    Loop** at = &wanting_;
    while (*at != &loop) at = &(*at)->below;
    *at = loop.below;
    missing_ -= loop.missing;
  }

  std::mutex mutex_;
  std::condition_variable work_;  ///< a loop wants helpers
  Loop* wanting_ = nullptr;       ///< the latest of them
  unsigned missing_ = 0;          ///< helpers of all loops on the list
  unsigned threads_ = 0, busy_ = 0;
};

alignas(Pool) std::byte memory[sizeof(Pool)];
Pool* make_pool() { return new (memory) Pool; }
Pool* const pool = [] {
  pthread_atfork(nullptr, nullptr, [] { make_pool(); });  // in its parent's state it would hang
  return make_pool();
}();

}  // namespace

void parallel_for(unsigned threads, std::uint64_t count, const Body& body) {
  const auto workers = static_cast<unsigned>(std::min<std::uint64_t>(std::max(threads, 1u), count));
  if (workers <= 1) {
    for (std::uint64_t i = 0; i < count; ++i) body(0, i);
    return;
  }
  Loop loop(count, workers - 1, body);
  pool->run(loop);
  if (loop.failure) std::rethrow_exception(loop.failure);
}

}  // namespace cvr::volumes
