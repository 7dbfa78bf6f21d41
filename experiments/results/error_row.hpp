// The errors of a decoded volume as they stand in rows and in what `error` prints.
#pragma once

#include <optional>

#include "experiments/results/result.hpp"
#include "volumes/metrics/error_sink.hpp"

namespace cvr::experiments {

/// The errors of a scalar volume; relative_error {p50, p90, p99} of f32, time_steps, worst_step and
/// worst_step_psnr_db of a series.
Parts::Error describe_errors(const volumes::ErrorSink& sink);

/// JSON has no infinity: null says that there is no number.
Nullable<double> finite_or_null(std::optional<double> value);

}  // namespace cvr::experiments
