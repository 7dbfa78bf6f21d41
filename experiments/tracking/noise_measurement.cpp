#include "experiments/tracking/noise_measurement.hpp"

#include <algorithm>

#include "experiments/statistics.hpp"

namespace cvr::experiments {

namespace {
constexpr double kLeastFloor = 0.01, kQuantile = 0.9;
}

Row measure_floors(const std::vector<Repeat>& repeats, bool paired) {
  std::map<std::string_view, std::vector<double>> deviations;
  for (const auto& [first, second] : repeats) {
    const CompareReport report = compare_rows(first, second, {{}, paired});
    for (const ComparedQuantity& c : report.comparisons) {
      if (c.base.kind != QuantityKind::kTime || c.outcome == Outcome::kNotCompared) continue;
      deviations[c.base.noise_class].push_back(std::max(c.ratio, 1 / c.ratio) - 1);
    }
  }
  Row measured = Row::object();
  for (auto& [noise_class, found] : deviations) {
    std::ranges::sort(found);
    Row& entry = measured[std::string(noise_class)];
    entry["floor"] = std::max(kLeastFloor, quantile(found, kQuantile));
    entry["cells"] = found.size();
    entry["median"] = quantile(found, 0.5);
    entry["largest"] = found.back();
  }
  return measured;
}

}  // namespace cvr::experiments
