#include "experiments/stages/frame_times.hpp"

#include <algorithm>
#include <span>
#include <string>

#include "experiments/results/statistics.hpp"

namespace cvr::experiments {

namespace {

constexpr std::size_t kFirstFrames = 16;
constexpr double kMs = 1e3;

std::vector<double> ascending_ms(std::span<const double> seconds) {
  std::vector<double> ms;
  for (const double s : seconds) ms.push_back(kMs * s);
  std::ranges::sort(ms);
  return ms;
}

double mean_of(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// Statistics of ascending milliseconds.
Row describe_ms(std::span<const double> ms) {
  return {{"min_ms", ms.front()},           {"mean_ms", mean_of(ms)},
          {"median_ms", quantile(ms, 0.5)}, {"p95_ms", quantile(ms, 0.95)},
          {"p99_ms", quantile(ms, 0.99)},   {"max_ms", ms.back()}};
}

Row describe_incomplete(std::span<const std::uint64_t> counts) {
  std::vector<double> ascending(counts.begin(), counts.end());
  std::ranges::sort(ascending);
  return {{"first", counts.front()},
          {"median", quantile(ascending, 0.5)},
          {"largest", ascending.back()}};
}

/// What the frames of the path and those of the held view have in common; null without frames.
/// `passes` begins their passes' series.
Row describe_series(const Measured& measured, const std::string& name, const std::string& passes) {
  const auto frames = std::ranges::find(measured.series, name, &Measured::Series::name);
  if (frames == measured.series.end()) return nullptr;
  const std::span<const double> all = frames->wall_seconds;
  const std::size_t count = all.size() / measured.rounds;
  const std::size_t warm = measured.rounds > 1 ? count : 0;  // where the later rounds begin
  const auto ms = ascending_ms(all.subspan(warm));
  Row row;
  row["count"] = count;
  row["rounds"] = measured.rounds;
  row.update(describe_ms(ms));
  const auto wall = ascending_ms(std::span(frames->cpu_seconds).subspan(warm));
  row["wall"] = describe_ms(wall);
  for (const Measured::Series& series : measured.series) {
    if (!series.name.starts_with(passes)) continue;
    const std::size_t later = std::min(warm, series.wall_seconds.size());
    const auto pass = ascending_ms(std::span(series.wall_seconds).subspan(later));
    if (pass.empty()) continue;
    row["passes"][series.name.substr(passes.size())] = {{"median_ms", quantile(pass, 0.5)},
                                                        {"mean_ms", mean_of(pass)}};
  }
  row["host_median_ms"] = row["wall"]["median_ms"];
  row["incomplete"] = describe_incomplete(frames->counts);
  row["ms"] = Row::array();
  for (std::size_t at = 0; at < all.size(); at += count) {
    Row round = Row::array();
    for (const double s : all.subspan(at, count)) round.push_back(kMs * s);
    row["ms"].push_back(std::move(round));
  }
  return row;
}

}  // namespace

Row describe_frames(const Measured& measured) {
  Row row = describe_series(measured, "frame", "pass/");
  std::vector<double> first_of_round;
  for (const Row& round : row["ms"]) first_of_round.push_back(round[0].get<double>());
  std::ranges::sort(first_of_round);
  const auto first_round = row["ms"][0].get<std::vector<double>>();
  row["first_round_mean_ms"] = mean_of(first_round);
  row["first_frame_ms"] = quantile(first_of_round, 0.5);
  row["first"] = Row::array();
  for (const double ms : std::span(first_round).first(std::min(first_round.size(), kFirstFrames)))
    row["first"].push_back(ms);
  return row;
}

Row describe_held_frames(const Measured& measured) {
  return describe_series(measured, "held", "held-pass/");
}

}  // namespace cvr::experiments
