#include "experiments/run/memory_model.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cvr::experiments {

namespace {

double bytes_of(const volumes::VolumeInfo& info) { return static_cast<double>(info.bytes()); }

/// The volume that a row is about.
std::optional<volumes::VolumeInfo> info_of(const Result& row) {
  const Result::Dataset& dataset = row.dataset;
  if (!dataset.extent || !dataset.type || !dataset.kind) return std::nullopt;
  const auto type = volumes::voxel_type_from_name(*dataset.type);
  const auto kind = volumes::volume_kind_from_name(*dataset.kind);
  if (!type || !kind) return std::nullopt;
  const auto& [x, y, z] = *dataset.extent;
  return volumes::VolumeInfo{.extent = {x, y, z},
                             .type = *type,
                             .kind = *kind,
                             .voxel_unit = {},
                             .time_steps = dataset.time_steps.value_or(1)};
}

double measured(const Result& row) { return static_cast<double>(*row.memory->peak_over_input); }

/// Whether a row measured the same work on whatever volume.
bool same_work(const Result& row, const Cell& cell) {
  const auto same = [](const auto& a, const auto& b) {
    return a.first == b.first && a.second == b.second;
  };
  return row.stage == cell.stage->id && row.threads == cell.threads.count &&
         row.codec.id == cell.codec && row.codec.version == cell.codec_version &&
         std::ranges::equal(row.codec.parameters, cell.parameters.values(), same);
}

}  // namespace

double modelled_memory(const Cell& cell, const volumes::VolumeInfo& info,
                       const MemoryChoices& choices) {
  return kind_of(cell).expected_memory(cell, info, choices);
}

MemoryForecast::MemoryForecast(const std::vector<Result>& rows, MemoryChoices choices)
    : choices_(std::move(choices)) {
  for (auto at = rows.rbegin(); at != rows.rend(); ++at) {
    if (at->is_ok() && at->memory && at->memory->peak_over_input) rows_.push_back(&*at);
  }
}

std::uint64_t MemoryForecast::of(const Cell& cell, const std::string& cell_id,
                                 const volumes::VolumeInfo& info) const {
  const auto same =
      std::ranges::find_if(rows_, [&](const Result* row) { return row->cell == cell_id; });
  if (same != rows_.end()) return static_cast<std::uint64_t>(measured(**same));
  const double model = modelled_memory(cell, info, choices_);
  if (!kind_of(cell).memory_scales()) return static_cast<std::uint64_t>(model);
  double scale = 1, least_distance = 1e300;
  for (const Result* row : rows_) {
    if (!same_work(*row, cell)) continue;
    const auto other = info_of(*row);
    if (!other || other->kind != info.kind || other->type != info.type) continue;
    const double distance = std::abs(std::log(bytes_of(*other) / bytes_of(info)));
    if (distance >= least_distance) continue;
    least_distance = distance;
    scale = measured(*row) / modelled_memory(cell, *other, choices_);
  }
  return static_cast<std::uint64_t>(model * scale);
}

}  // namespace cvr::experiments
