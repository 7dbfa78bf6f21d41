// The columns that tables can have: each metric names the stage whose row it reads, its unit, and
// what it means.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/analysis/rate_distortion.hpp"
#include "experiments/analysis/reading.hpp"
#include "experiments/analysis/stage_rows.hpp"
#include "experiments/config/cells.hpp"
#include "experiments/config/metric_names.hpp"
#include "experiments/config/published.hpp"
#include "experiments/results/rows.hpp"

namespace cvr::experiments {

/// What one line of a table is made of. Rows that do not exist are nullptr.
struct LineContext {
  StageRows rows;
  const PublishedFigure* published = nullptr;
  bool pseudo = false;           ///< a line of memcpy: has no size
  bool on_front = false;         ///< no line of the same data set has fewer bits and a higher PSNR
  bool on_access_front = false;  ///< ... fewer bits and faster access to uniform points
};

struct Metric {
  std::string_view name;
  std::string_view heading;  ///< with the unit
  std::string_view description;
  Reading (*read)(const LineContext&);
  bool numeric = true;          ///< whether what it reads is a number, as claims need it
  bool of_publication = false;  ///< whether it reads what a publication states
};

/// What the publication states; empty where it states nothing of the line.
Reading published_reading(const LineContext& line, std::optional<double> PublishedFigure::*figure,
                          int digits);

/// Bits a voxel and PSNR of the line, infinity where it is exact; none where no stage that is ok
/// knows both.
std::optional<RatePoint> rate_point(const LineContext& line);

/// Bits a voxel of the line and, as its quality, minus the ns that a uniform point of the finest
/// level takes.
std::optional<RatePoint> access_point(const LineContext& line);

std::span<const Metric> all_metrics();
const Metric* find_metric(std::string_view name);
/// All of them, as configurations know them.
MetricNames metric_names();

}  // namespace cvr::experiments
