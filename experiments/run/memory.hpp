// How much memory this process may take.
#pragma once

#include <cstdint>

namespace cvr::experiments {

/// Bytes that this process may still allocate: what the system has, what its control group leaves,
/// and what the limits on its address space and data (ulimit -v, -d) leave, whichever is least.
std::uint64_t usable_memory();

}  // namespace cvr::experiments
