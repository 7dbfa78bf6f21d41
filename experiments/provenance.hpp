// Where a row comes from: the program and how it was built, the machine and its system.
#pragma once

#include <cstdint>
#include <string>

#include "experiments/rows.hpp"

namespace cvr::experiments {

/// revision, version, compiler, flags, build_type, cpu, cores, memory_bytes, kernel, os, and `machine`: a
/// fingerprint of cpu, cores and memory. Times compare only between rows with the same fingerprint.
Row describe_machine_and_build();

/// "2026-01-31T12:00:00Z".
std::string utc_now();

/// "AMD Ryzen ..., 16 cores, 64 GiB, Linux 6.1.0, GNU 12.2.0 (-O3 ...), revision abc": the line above every
/// table.
std::string hardware_line(const Row& provenance);

/// Bytes that can be allocated without swapping, from /proc/meminfo; 0 if unknown.
std::uint64_t available_memory();

}  // namespace cvr::experiments
