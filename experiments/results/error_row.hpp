// The errors of a decoded volume as they stand in rows and in what `error` prints.
#pragma once

#include <optional>

#include "experiments/results/rows.hpp"
#include "volumes/metrics/error_sink.hpp"

namespace cvr::experiments {

/// The errors of a scalar volume by name: psnr_db (null where equal), exact, largest_error,
/// mean_squared_error, mean_absolute_error, edge_mean_squared_error, edge_psnr_db, edge_voxels,
/// non_finite_voxels, of f32 relative_error {p50, p90, p99}, and of a series time_steps, worst_step
/// and worst_step_psnr_db.
Row describe_errors(const volumes::ErrorSink& sink);

/// JSON has no infinity: null says that there is no number.
Row finite_or_null(std::optional<double> value);

}  // namespace cvr::experiments
