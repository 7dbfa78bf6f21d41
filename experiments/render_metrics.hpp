// The columns of tables about pictures: what metrics.cpp joins to its own.
#pragma once

#include <span>

#include "experiments/metrics.hpp"

namespace cvr::experiments {

std::span<const Metric> render_metrics();

}  // namespace cvr::experiments
