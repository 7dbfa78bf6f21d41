// What a configuration must know of the metrics that its tables and claims name. The metrics
// themselves lie above, in analysis/metrics.hpp, which hands this list down.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cvr::experiments {

struct MetricName {
  std::string_view name;
  bool numeric = true;          ///< whether it is a number, as claims need it
  bool of_images = false;       ///< whether cells of the stage render alone have it
  bool published = false;       ///< whether publications state it too
  bool of_publication = false;  ///< whether it is what a publication states
};

using MetricNames = std::span<const MetricName>;

/// By its name or its former one; nullptr where no metric has this name.
const MetricName* find_metric_name(MetricNames metrics, std::string_view name);
std::vector<std::string> names_of(MetricNames metrics);

}  // namespace cvr::experiments
