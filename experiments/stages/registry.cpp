// All stages: one line each.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "experiments/results/error_row.hpp"
#include "experiments/stages/memcpy.hpp"
#include "experiments/stages/stage_kind.hpp"

namespace cvr::experiments {

std::span<const StageKind* const> all_stages() {
  static const std::array kAll{
      &encode_stage(),           &decode_stage(), &random_access_stage(),
      &label_statistics_stage(), &render_stage(),
  };
  return kAll;
}

StageList stage_traits() {
  static const std::vector<const StageTraits*> kTraits = [] {
    std::vector<const StageTraits*> traits;
    for (const StageKind* stage : all_stages()) traits.push_back(&stage->traits());
    return traits;
  }();
  return kTraits;
}

namespace {

const StageKind* find_kind(std::string_view id) {
  const auto stages = all_stages();
  const auto found =
      std::ranges::find(stages, id, [](const StageKind* stage) { return stage->traits().id; });
  return found == stages.end() ? nullptr : *found;
}

}  // namespace

const StageKind& kind_of(const Cell& cell) { return *find_kind(cell.stage->id); }

const StageKind& kind_of(const WorkerSpec& spec) {
  const StageKind* kind = find_kind(spec.stage);
  if (kind == nullptr) throw StageFailure(kUnsupported, fmt::format("no stage '{}'", spec.stage));
  return *kind;
}

std::unique_ptr<StageRun> make_stage_run(const StageInput& input) {
  if (input.spec.codec == kMemcpy) return make_memcpy_run(input);
  return kind_of(input.spec).make_run(input);
}

void StageKind::add_times(const Measured& measured, const volumes::VolumeInfo& info,
                          Parts& parts) const {
  const Measured::Series& series = measured.series.front();
  parts.time->seconds = describe_samples(series.wall_seconds);
  parts.time->cpu_seconds = describe_samples(series.cpu_seconds);
  const double median = parts.time->seconds->median;
  const double rate = median > 0 ? 1 / median : std::numeric_limits<double>::infinity();
  parts.time->gb_per_s = finite_or_null(1e-9 * static_cast<double>(info.bytes()) * rate);
  parts.time->mvoxel_per_s =
      finite_or_null(1e-6 * static_cast<double>(info.extent.voxels()) * rate);
  for (std::size_t step = 1; step < measured.series.size(); ++step)
    parts.steps.value().at(step - 1).seconds = describe_samples(measured.series[step].wall_seconds);
}

std::string StageKind::headline(const Parts& parts) const {
  return fmt::format("{:.4g} s", parts.time->seconds->median);
}

}  // namespace cvr::experiments
