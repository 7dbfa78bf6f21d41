// The columns of tables about images: what metrics.cpp joins to its own.
#pragma once

#include <span>

#include "experiments/analysis/metrics.hpp"

namespace cvr::experiments {

std::span<const Metric> render_metrics();

/// What a publication states of the same quantity, for tables that put both into one cell; nullptr
/// where there is nothing such.
const Metric* published_beside(const Metric& metric);

}  // namespace cvr::experiments
