#include "experiments/run/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "codecs/registry.hpp"
#include "experiments/run/memory_model.hpp"
#include "gpu/caches/cache.hpp"

namespace cvr::experiments {

namespace {

constexpr double kModelVoxelsPerSecond = 50e6;
constexpr double kModelMemcpyPerSecond = 1000e6;
constexpr double kModelAccessRound = 0.5;
constexpr double kModelPixelsPerSecond = 2e6;
constexpr double kModelCheckFrames = 20;

/// The reason why a codec cannot run a cell, as far as its traits tell.
std::string unsupported_reason(const Cell& cell, const volumes::VolumeInfo& info) {
  if (cell.codec == kMemcpy) return "";
  const auto& traits = codecs::find_codec(cell.codec)->traits();
  if (const auto accepted = codecs::accepts(traits, info); !accepted)
    return accepted.error().message;
  if (cell.stage == Stage::kRender) {
    const RenderChoice& choice = *cell.render;
    const bool labels = info.kind == volumes::VolumeKind::kLabels;
    if (!(labels ? traits.gpu_decodable : traits.gpu_scalars)) return "no decoder for the GPU";
    const gpu::CacheTraits& access = *gpu::find_cache(choice.access);
    if (labels)
      return access.labels ? "" : fmt::format("{} serves scalar volumes alone", access.id);
    if (!access.scalars) return fmt::format("{} serves label volumes alone", access.id);
    if (choice.shading != gpu::Shading::kLocal)
      return "scalar volumes are shaded by their gradients alone: local";
    return "";
  }
  if (cell.stage != Stage::kRandomAccess) return "";
  return traits.access == codecs::Granularity::kVolume ? "no access to single voxels" : "";
}

void expect_from_model(const Config& config, PlannedCell& planned) {
  const volumes::VolumeInfo& info = planned.location->info;
  const auto rounds = static_cast<double>(config.rounds);
  if (const auto& render = planned.cell.render) {
    const std::uint64_t pixels = std::uint64_t{render->width} * render->height;
    const double frames = kModelCheckFrames + (rounds + 1) * (render->frames * render->ao_samples +
                                                              render->held_frames);
    planned.expected_seconds = 4 + frames * static_cast<double>(pixels) / kModelPixelsPerSecond;
    return;
  }
  const double speed =
      planned.cell.codec == kMemcpy ? kModelMemcpyPerSecond : kModelVoxelsPerSecond;
  const double pass =
      static_cast<double>(info.extent.voxels()) / (speed * planned.cell.threads.count);
  planned.expected_seconds = planned.cell.stage == Stage::kRandomAccess
                                 ? 4 * pass + kModelAccessRound * rounds
                                 : (4 + rounds) * pass;
}

}  // namespace

std::string_view name_of(Decision decision) {
  switch (decision) {
    case Decision::kRun:
      return "run";
    case Decision::kDone:
      return "done";
    case Decision::kUnsupported:
      return "unsupported";
    case Decision::kDataMissing:
      return "data-missing";
  }
  return "?";
}

std::vector<PlannedCell> plan_cells(const Config& config, const Filter& filter,
                                    const Places& places, const std::vector<Row>& rows, bool redo) {
  const auto latest = latest_by(rows, "cell");
  const MemoryForecast memory(
      rows, {static_cast<std::uint64_t>(config.memory_limit_gib * (1 << 30)), config.lods});
  std::map<std::string, std::shared_ptr<const Location>> locations;
  std::vector<PlannedCell> plan;
  for (const Cell& cell : config.cells) {
    if (!filter.keeps(cell)) continue;
    PlannedCell planned;
    planned.cell = cell;
    const std::string place = fmt::format(
        "{}|{}|{}|{}|{}", cell.dataset->name, to_string(cell.dataset->generated_extent()),
        cell.dataset->exchange_axes, cell.dataset->axes, cell.dataset->allow_external);
    auto& location = locations[place];
    if (!location) location = std::make_shared<Location>(locate(*cell.dataset, places));
    planned.location = location;
    planned.id = cell_id(cell, location->present ? location->identity : "absent");
    const auto row = latest.find(planned.id);
    if (!location->present) {
      planned.decision = Decision::kDataMissing;
      planned.reason = location->missing;
    } else if (planned.reason = unsupported_reason(cell, location->info); !planned.reason.empty()) {
      planned.decision = Decision::kUnsupported;
    } else if (!redo && row != latest.end() && row->second.value("status", "") == kOk) {
      planned.decision = Decision::kDone;
    }
    if (location->present && planned.decision != Decision::kUnsupported) {
      expect_from_model(config, planned);
      planned.expected_memory = memory.of(cell, planned.id, location->info);
    }
    if (row != latest.end() && row->second.contains("elapsed_seconds")) {
      planned.expected_seconds = row->second.value("elapsed_seconds", 0.0);
      planned.expected_from_rows = true;
    }
    plan.push_back(std::move(planned));
  }
  return plan;
}

}  // namespace cvr::experiments
