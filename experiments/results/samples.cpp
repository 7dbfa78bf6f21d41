#include "experiments/results/samples.hpp"

namespace cvr::experiments {

Row to_row(const std::vector<Sample>& samples) {
  Row row = Row::array();
  for (const Sample& s : samples)
    row.push_back(Row::array({s.series, s.wall_seconds, s.cpu_seconds, s.count}));
  return row;
}

std::optional<std::vector<Sample>> samples_from(const Row& row) {
  if (!row.is_array() || row.empty()) return std::nullopt;
  std::vector<Sample> samples;
  for (const Row& s : row) {
    if (!s.is_array() || s.size() != 4 || !s[0].is_string() || !s[1].is_number() ||
        !s[2].is_number() || !s[3].is_number_unsigned()) {
      return std::nullopt;
    }
    Sample sample{s[0].get<std::string>(), s[1].get<double>(), s[2].get<double>(),
                  s[3].get<std::uint64_t>()};
    if (sample.wall_seconds < 0 || sample.cpu_seconds < 0) return std::nullopt;
    samples.push_back(std::move(sample));
  }
  return samples;
}

}  // namespace cvr::experiments
