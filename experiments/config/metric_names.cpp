#include "experiments/config/metric_names.hpp"

#include <algorithm>

#include "experiments/config/former_names.hpp"

namespace cvr::experiments {

const MetricName* find_metric_name(MetricNames metrics, std::string_view name) {
  const auto found = std::ranges::find(metrics, current_name(name), &MetricName::name);
  return found == metrics.end() ? nullptr : &*found;
}

std::vector<std::string> names_of(MetricNames metrics) {
  std::vector<std::string> names;
  for (const MetricName& metric : metrics) names.emplace_back(metric.name);
  return names;
}

}  // namespace cvr::experiments
