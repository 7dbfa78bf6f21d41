// A parallel loop whose results never depend on the number of threads: which worker takes which
// index is not fixed, so bodies write only what belongs to their index and use the worker number
// for scratch memory alone. Threads are kept for later calls (docs/decisions/threads.md).
#pragma once

#include <cstdint>
#include <functional>

namespace cvr::volumes {

/// Calls body(worker, index) once for every index < count, on up to `threads` >= 1 threads (worker
/// < threads). The caller's thread is worker 0; a body may call parallel_for. Rethrows the first
/// exception of a body after all workers have stopped.
void parallel_for(unsigned threads, std::uint64_t count,
                  const std::function<void(unsigned worker, std::uint64_t index)>& body);

}  // namespace cvr::volumes
