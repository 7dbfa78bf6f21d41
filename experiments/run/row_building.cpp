#include "experiments/run/row_building.hpp"

#include <fmt/format.h>

#include "experiments/results/error_row.hpp"
#include "experiments/results/provenance.hpp"
#include "experiments/stages/stage_kind.hpp"

namespace cvr::experiments {

Result start_result(const PlannedCell& planned, const RawCopy& copy, const Provenance& provenance,
                    const std::string& config_hash, std::string_view status,
                    const std::string& reason) {
  const Cell& cell = planned.cell;
  const Location& location = *planned.location;
  Result result;
  result.cell = planned.id;
  result.key = cell.row_key();
  result.status = status;
  result.reason = reason;
  Result::Dataset& dataset = result.dataset;
  dataset.name = cell.dataset->name;
  dataset.title = cell.dataset->title;
  dataset.label = location.label;
  if (location.present) {
    const volumes::VolumeInfo& info = location.info;
    dataset.extent = {info.extent.x, info.extent.y, info.extent.z};
    if (info.time_steps > 1) dataset.time_steps = info.time_steps;
    dataset.type = name_of(info.type);
    dataset.kind = name_of(info.kind);
    dataset.voxels = info.extent.voxels();
    dataset.original_voxels = cell.dataset->full_extent.voxels();
    dataset.bytes = info.bytes();
    dataset.identity = location.identity;
    dataset.content_hash.emplace();
    if (!copy.content_hash.empty()) dataset.content_hash->emplace(copy.content_hash);
    if (copy.labels > 0) dataset.labels = copy.labels;
    if (cell.dataset->labels > 0) dataset.original_labels = cell.dataset->labels;
    dataset.source = copy.path.empty() ? "streamed" : "mapped copy";
  }
  result.codec.id = cell.codec;
  result.codec.version = cell.codec_version;
  for (const auto& [name, value] : cell.parameters.values()) result.codec.parameters[name] = value;
  result.stage = cell.stage->id;
  result.threads = cell.threads.count;
  if (cell.render) {
    result.render = to_row(*cell.render);
    result.render->erase("scene_path");
  }
  result.provenance = provenance;
  result.provenance.config_hash = config_hash;
  result.provenance.time = utc_now();
  return result;
}

std::string describe_end(const PlannedCell& planned, const Result& result) {
  const std::string text = fmt::format("{}: {}", planned.cell.describe(), result.status);
  if (!result.is_ok()) return fmt::format("{} ({})", text, result.reason);
  const std::string headline = kind_of(planned.cell).headline(result);
  return fmt::format("{}{}{}, {} rounds", text, headline.empty() ? "" : ", ", headline,
                     *result.time->rounds);
}

void add_times(const PlannedCell& planned, const Measured& measured, const std::string& stop,
               Parts& parts) {
  Parts::Time& time = parts.time.emplace();
  time.rounds = measured.rounds;
  time.stop = stop;
  time.relative_interval = finite_or_null(measured.relative_interval());
  kind_of(planned.cell).add_times(measured, planned.location->info, parts);
}

}  // namespace cvr::experiments
