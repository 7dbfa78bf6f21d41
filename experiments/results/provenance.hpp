// Where a row comes from: the program and how it was built, the machine and its system.
#pragma once

#include <cstdint>
#include <string>

#include "experiments/results/result.hpp"

namespace cvr::experiments {

/// revision, version, compiler, flags, build_type, cpu, cores, memory_bytes, kernel, os, and
/// `machine`: a fingerprint of cpu, cores and memory. Times compare only between rows with the same
/// fingerprint. Beside these what may explain a difference: libc, versions of the libraries, CPU
/// features that the program was compiled for and that are there, and settings of the system
/// (governor, turbo, transparent huge pages), "unknown" where it does not tell.
Provenance describe_machine_and_build();

/// A text of machine and build without the settings of the system: rounds with different texts are
/// not mixed.
std::string what_times_depend_on(const Provenance& provenance);

/// "2026-01-31T12:00:00Z".
std::string utc_now();

/// "AMD Ryzen ..., 16 cores, 64 GiB, Linux 6.1.0, GNU 12.2.0 (-O3 ...), revision abc": the line
/// above every table.
std::string hardware_line(const Provenance& provenance);

/// Bytes that can be allocated without swapping, from /proc/meminfo; 0 if unknown.
std::uint64_t available_memory();

}  // namespace cvr::experiments
