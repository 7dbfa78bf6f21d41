#include "experiments/results/error_row.hpp"

#include <cmath>

namespace cvr::experiments {

Row finite_or_null(std::optional<double> value) {
  return value && std::isfinite(*value) ? Row(*value) : Row(nullptr);
}

Row describe_errors(const volumes::ErrorSink& sink) {
  Row row;
  row["psnr_db"] = finite_or_null(sink.psnr());
  row["exact"] = sink.mismatches() == 0;
  row["largest_error"] = finite_or_null(sink.largest_error());
  row["mean_squared_error"] = finite_or_null(sink.mean_squared_error());
  row["mean_absolute_error"] = finite_or_null(sink.mean_absolute_error());
  row["edge_mean_squared_error"] = finite_or_null(sink.edge_mean_squared_error());
  row["edge_psnr_db"] = finite_or_null(sink.edge_psnr());
  row["edge_voxels"] = sink.edge_voxels();
  row["non_finite_voxels"] = sink.non_finite();
  if (sink.time_steps() > 1) {
    row["time_steps"] = sink.time_steps();
    row["worst_step"] = sink.worst_step();
    row["worst_step_psnr_db"] = finite_or_null(sink.worst_step_psnr());
  }
  if (sink.relative_error(0.5)) {
    Row& relative = row["relative_error"];
    relative["p50"] = finite_or_null(sink.relative_error(0.5));
    relative["p90"] = finite_or_null(sink.relative_error(0.9));
    relative["p99"] = finite_or_null(sink.relative_error(0.99));
  }
  return row;
}

}  // namespace cvr::experiments
