// Rows for other tools: the JSON of Google Benchmark (compare.py, Bencher, github-action-benchmark
// read it) and CSV.
#pragma once

#include <string>
#include <vector>

#include "experiments/results/rows.hpp"

namespace cvr::experiments {

/// One benchmark a kind of time of each cell that is ok (the last row counts), named
/// DATASET/CODEC/PARAMETERS/.../TIME: an entry of run_type "iteration" a sample and the aggregates
/// mean, median, stddev and cv. Times in ns; cpu_time is that of the samples where rows have it,
/// else the real time. Exact figures of the row stand beside as counters (bytes, bits_per_voxel,
/// psnr_db).
Row to_google_benchmark(const std::vector<Result>& rows);

/// One line a row, in their order: every text, number and flag of any row as a column named by its
/// place ("size.breakdown.index"), in order of first occurrence; lists are left out. RFC 4180.
std::string to_csv(const std::vector<Result>& rows);

}  // namespace cvr::experiments
