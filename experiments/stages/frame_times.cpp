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

/// Of ascending milliseconds.
Parts::Spread describe_ms(std::span<const double> ms) {
  return {.min_ms = ms.front(),
          .mean_ms = mean_of(ms),
          .median_ms = quantile(ms, 0.5),
          .p95_ms = quantile(ms, 0.95),
          .p99_ms = quantile(ms, 0.99),
          .max_ms = ms.back()};
}

Parts::Incomplete describe_incomplete(std::span<const std::uint64_t> counts) {
  std::vector<double> ascending(counts.begin(), counts.end());
  std::ranges::sort(ascending);
  return {counts.front(), quantile(ascending, 0.5), ascending.back()};
}

/// What the frames of the path and those of the held view have in common, into `times`; false
/// without frames. `passes` begins their passes' series.
bool describe_series(const Measured& measured, const std::string& name, const std::string& passes,
                     Parts::FrameTimes& times) {
  const auto frames = std::ranges::find(measured.series, name, &Measured::Series::name);
  if (frames == measured.series.end()) return false;
  const std::span<const double> all = frames->wall_seconds;
  const std::size_t count = all.size() / measured.rounds;
  const std::size_t warm = measured.rounds > 1 ? count : 0;  // where the later rounds begin
  static_cast<Parts::Spread&>(times) = describe_ms(ascending_ms(all.subspan(warm)));
  times.count = count;
  times.rounds = measured.rounds;
  times.wall = describe_ms(ascending_ms(std::span(frames->cpu_seconds).subspan(warm)));
  for (const Measured::Series& series : measured.series) {
    if (!series.name.starts_with(passes)) continue;
    const std::size_t later = std::min(warm, series.wall_seconds.size());
    const auto pass = ascending_ms(std::span(series.wall_seconds).subspan(later));
    if (pass.empty()) continue;
    if (!times.passes) times.passes.emplace();
    (*times.passes)[series.name.substr(passes.size())] = {quantile(pass, 0.5), mean_of(pass)};
  }
  times.host_median_ms = times.wall->median_ms;
  times.incomplete = describe_incomplete(frames->counts);
  for (std::size_t at = 0; at < all.size(); at += count) {
    auto& round = times.ms.emplace_back();
    for (const double s : all.subspan(at, count)) round.push_back(kMs * s);
  }
  return true;
}

}  // namespace

std::optional<Parts::Frames> describe_frames(const Measured& measured) {
  Parts::Frames frames;
  if (!describe_series(measured, "frame", "pass/", frames)) return std::nullopt;
  std::vector<double> first_of_round;
  for (const auto& round : frames.ms) first_of_round.push_back(round.front());
  std::ranges::sort(first_of_round);
  const std::vector<double>& first = frames.ms.front();
  frames.first_round_mean_ms = mean_of(first);
  frames.first_frame_ms = quantile(first_of_round, 0.5);
  frames.first.assign(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(
                                                         std::min(first.size(), kFirstFrames)));
  return frames;
}

bool add_held_frames(const Measured& measured, Parts::Held& held) {
  return describe_series(measured, "held", "held-pass/", held);
}

}  // namespace cvr::experiments
