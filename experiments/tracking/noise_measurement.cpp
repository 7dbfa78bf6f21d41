#include "experiments/tracking/noise_measurement.hpp"

#include <algorithm>

#include "experiments/config/cells.hpp"
#include "experiments/results/statistics.hpp"

namespace cvr::experiments {

namespace {
/// Two processes of one program differ by a few percent for as long as they live (where their
/// memory lies); two runs by what the machine did meanwhile. A few repeats see little of either, so
/// no floor is less, and the largest gap counts twice.
constexpr double kLeastInterleaved = 0.05, kLeastApart = 0.1, kMargin = 2;

struct Deviations {
  std::vector<double> ratios;  ///< |ratio - 1|
  double gap = 0;              ///< the largest
};
}  // namespace

Row measure_floors(const std::vector<Repeat>& repeats, bool paired) {
  std::map<std::string_view, Deviations> deviations;
  for (const auto& [first, second] : repeats) {
    const CompareReport report = compare_rows(first, second, {{}, paired});
    for (const ComparedQuantity& c : report.comparisons) {
      if (c.base.kind != QuantityKind::kTime || c.outcome == Outcome::kNotCompared ||
          c.codec == kMemcpy)
        continue;
      Deviations& found = deviations[c.base.noise_class];
      found.ratios.push_back(std::max(c.ratio, 1 / c.ratio) - 1);
      found.gap = std::max(found.gap, c.gap);
    }
  }
  Row measured = Row::object();
  for (auto& [noise_class, found] : deviations) {
    std::ranges::sort(found.ratios);
    Row& entry = measured[std::string(noise_class)];
    entry["floor"] = std::max(paired ? kLeastInterleaved : kLeastApart, kMargin * found.gap);
    entry["cells"] = found.ratios.size();
    entry["median"] = quantile(found.ratios, 0.5);
    entry["largest"] = found.ratios.back();
  }
  return measured;
}

}  // namespace cvr::experiments
