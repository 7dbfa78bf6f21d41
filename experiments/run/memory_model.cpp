#include "experiments/run/memory_model.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cvr::experiments {

namespace {

double bytes_of(const volumes::VolumeInfo& info) { return static_cast<double>(info.bytes()); }

/// The volume that a row is about.
std::optional<volumes::VolumeInfo> info_of(const Row& row) {
  const Row& dataset = row.at("dataset");
  if (!dataset.contains("extent") || !dataset.contains("type") || !dataset.contains("kind"))
    return std::nullopt;
  const auto type = volumes::voxel_type_from_name(dataset["type"].get<std::string>());
  const auto kind = volumes::volume_kind_from_name(dataset["kind"].get<std::string>());
  const auto extent = dataset["extent"].get<std::vector<std::uint64_t>>();
  if (!type || !kind || extent.size() != 3) return std::nullopt;
  return volumes::VolumeInfo{.extent = {extent[0], extent[1], extent[2]},
                             .type = *type,
                             .kind = *kind,
                             .voxel_unit = {},
                             .time_steps = dataset.value("time_steps", std::uint64_t{1})};
}

double measured(const Row& row) { return row["memory"]["peak_over_input"].get<double>(); }

/// Whether a row measured the same work on whatever volume.
bool same_work(const Row& row, const Cell& cell) {
  if (row.value("stage", "") != cell.stage->id || row.value("threads", 0u) != cell.threads.count)
    return false;
  const Row& codec = row.at("codec");
  return codec.value("id", "") == cell.codec && codec.value("version", 0u) == cell.codec_version &&
         codec.at("parameters") == Row(cell.parameters.values());
}

}  // namespace

double modelled_memory(const Cell& cell, const volumes::VolumeInfo& info,
                       const MemoryChoices& choices) {
  return kind_of(cell).expected_memory(cell, info, choices);
}

MemoryForecast::MemoryForecast(const std::vector<Row>& rows, MemoryChoices choices)
    : choices_(std::move(choices)) {
  const Row::json_pointer memory("/memory/peak_over_input");
  for (auto at = rows.rbegin(); at != rows.rend(); ++at) {
    const Row& row = *at;
    const bool tells = row.value("status", "") == kOk && row.contains(memory) &&
                       row.at(memory).is_number() && row.contains("dataset") &&
                       row.contains("codec");
    if (tells) rows_.push_back(&row);
  }
}

std::uint64_t MemoryForecast::of(const Cell& cell, const std::string& cell_id,
                                 const volumes::VolumeInfo& info) const {
  const auto same = std::ranges::find_if(
      rows_, [&](const Row* row) { return row->value("cell", "") == cell_id; });
  if (same != rows_.end()) return static_cast<std::uint64_t>(measured(**same));
  const double model = modelled_memory(cell, info, choices_);
  if (!kind_of(cell).memory_scales()) return static_cast<std::uint64_t>(model);
  double scale = 1, least_distance = 1e300;
  for (const Row* row : rows_) {
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
