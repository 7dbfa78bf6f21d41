#include "experiments/results/error_row.hpp"

#include <cmath>

namespace cvr::experiments {

Nullable<double> finite_or_null(std::optional<double> value) {
  return value && std::isfinite(*value) ? value : std::nullopt;
}

Parts::Error describe_errors(const volumes::ErrorSink& sink) {
  Parts::Error error;
  error.psnr_db = finite_or_null(sink.psnr());
  error.exact = sink.mismatches() == 0;
  error.largest_error = finite_or_null(sink.largest_error());
  error.mean_squared_error = finite_or_null(sink.mean_squared_error());
  error.mean_absolute_error = finite_or_null(sink.mean_absolute_error());
  error.edge_mean_squared_error = finite_or_null(sink.edge_mean_squared_error());
  error.edge_psnr_db = finite_or_null(sink.edge_psnr());
  error.edge_voxels = sink.edge_voxels();
  error.non_finite_voxels = sink.non_finite();
  if (sink.time_steps() > 1) {
    error.time_steps = sink.time_steps();
    error.worst_step = sink.worst_step();
    error.worst_step_psnr_db = finite_or_null(sink.worst_step_psnr());
  }
  if (sink.relative_error(0.5)) {
    auto& relative = error.relative_error.emplace();
    relative["p50"] = finite_or_null(sink.relative_error(0.5));
    relative["p90"] = finite_or_null(sink.relative_error(0.9));
    relative["p99"] = finite_or_null(sink.relative_error(0.99));
  }
  return error;
}

}  // namespace cvr::experiments
