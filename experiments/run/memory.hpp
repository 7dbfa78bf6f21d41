// How much memory this process may take.
#pragma once

#include <cstdint>
#include <filesystem>

namespace cvr::experiments {

/// Bytes that this process may still allocate: what the system has, what its control group leaves,
/// and what the limits on its address space and data (ulimit -v, -d) leave, whichever is least.
std::uint64_t usable_memory();

/// What the control groups leave of a process, its own and those above, by version 2 and by the
/// memory controller of version 1; everything where none has a limit. `membership` is the process's
/// /proc/PID/cgroup, `mount` is where control groups lie, /sys/fs/cgroup.
std::uint64_t left_of_control_groups(const std::filesystem::path& membership,
                                     const std::filesystem::path& mount);

}  // namespace cvr::experiments
