#include "experiments/run/memory_model.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "codecs/estimates.hpp"
#include "codecs/registry.hpp"
#include "experiments/stages/points.hpp"

namespace cvr::experiments {

namespace {

constexpr double kMiB = 1 << 20;
constexpr double kProcess = 15.6 * kMiB;  ///< program and libraries, as far as they are touched
constexpr double kThread = 0.25 * kMiB;   ///< of stack and heap, for each beside the first
constexpr double kDriver = 256 * kMiB;    ///< of a renderer
constexpr double kPixel = 100;            ///< bytes, of images on the device and here
constexpr std::uint64_t kSlabPlanes = 64;

double bytes_of(const volumes::VolumeInfo& info) { return static_cast<double>(info.bytes()); }

/// Where decoded voxels go: the whole volume, or one slab.
double destination(const volumes::VolumeInfo& info, const MemoryChoices& choices) {
  if (choices.limit == 0 || info.bytes() <= choices.limit / 2) return bytes_of(info);
  const std::uint64_t planes = std::min(info.extent.z, kSlabPlanes);
  return static_cast<double>(info.extent.x * info.extent.y * planes * size_of(info.type));
}

double memory_of_points(const codecs::Traits& traits, const codecs::MemoryEstimate& need,
                        const volumes::VolumeInfo& info, const MemoryChoices& choices) {
  const bool labels = info.kind == volumes::VolumeKind::kLabels;
  const double levels = choices.lods.empty()
                            ? need.levels
                            : std::min(need.levels, static_cast<double>(choices.lods.size()));
  const std::uint64_t count =
      points_a_series(need.access_ns, levels, traits.access == codecs::Granularity::kBrick);
  return static_cast<double>(count) *
         ((labels ? 3 : 2) * sizeof(volumes::Coordinate) + sizeof(std::uint64_t));
}

double render_memory(const RenderChoice& render, const volumes::VolumeInfo& info) {
  // Labels in memory, as the pyramid of the reference, and encoded; the cache of the timed and of
  // the counting renderer.
  const auto pixels = static_cast<double>(std::uint64_t{render.width} * render.height);
  return 4 * bytes_of(info) + 8 * static_cast<double>(info.extent.voxels()) +
         static_cast<double>(render.cache_mib) * 2 * kMiB + kPixel * pixels + kDriver;
}

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
  if (row.value("stage", "") != name_of(cell.stage) ||
      row.value("threads", 0u) != cell.threads.count)
    return false;
  const Row& codec = row.at("codec");
  return codec.value("id", "") == cell.codec && codec.value("version", 0u) == cell.codec_version &&
         codec.at("parameters") == Row(cell.parameters.values());
}

}  // namespace

double modelled_memory(const Cell& cell, const volumes::VolumeInfo& info,
                       const MemoryChoices& choices) {
  if (cell.render) return render_memory(*cell.render, info);
  const double process = kProcess + kThread * (cell.threads.count - 1.0);
  const double to = destination(info, choices);
  if (cell.codec == kMemcpy)
    return process + to + (cell.stage == Stage::kDecode ? bytes_of(info) : 0);
  const codecs::Codec& codec = *codecs::find_codec(cell.codec);
  const codecs::MemoryEstimate need =
      codecs::estimate_memory(codec, info, cell.parameters, cell.threads.count);
  switch (cell.stage) {
    case Stage::kEncode:
      return process + need.file + need.encode;
    case Stage::kDecode:
      return process + need.file + need.decode + to;
    default:
      return process + need.file + need.open +
             memory_of_points(codec.traits(), need, info, choices);
  }
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
  if (cell.render) return static_cast<std::uint64_t>(model);
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
