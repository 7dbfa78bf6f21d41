#include "experiments/run/row_building.hpp"

#include <fmt/format.h>

#include "experiments/results/error_row.hpp"
#include "experiments/results/provenance.hpp"
#include "experiments/stages/stage_kind.hpp"

namespace cvr::experiments {

namespace {

constexpr int kSchemaVersion = 1;

}  // namespace

Row start_row(const PlannedCell& planned, const RawCopy& copy, const Row& provenance,
              const std::string& config_hash, std::string_view status, const std::string& reason) {
  const Cell& cell = planned.cell;
  const Location& location = *planned.location;
  Row row;
  row["schema"] = kSchemaVersion;
  row["cell"] = planned.id;
  row["key"] = cell.row_key();
  row["status"] = status;
  row["reason"] = reason;
  Row& dataset = row["dataset"];
  dataset["name"] = cell.dataset->name;
  dataset["title"] = cell.dataset->title;
  dataset["label"] = location.label;
  if (location.present) {
    const volumes::VolumeInfo& info = location.info;
    dataset["extent"] = {info.extent.x, info.extent.y, info.extent.z};
    if (info.time_steps > 1) dataset["time_steps"] = info.time_steps;
    dataset["type"] = name_of(info.type);
    dataset["kind"] = name_of(info.kind);
    dataset["voxels"] = info.extent.voxels();
    dataset["original_voxels"] = cell.dataset->full_extent.voxels();
    dataset["bytes"] = info.bytes();
    dataset["identity"] = location.identity;
    dataset["content_hash"] = copy.content_hash.empty() ? Row(nullptr) : Row(copy.content_hash);
    if (copy.labels > 0) dataset["labels"] = copy.labels;
    if (cell.dataset->labels > 0) dataset["original_labels"] = cell.dataset->labels;
    dataset["source"] = copy.path.empty() ? "streamed" : "mapped copy";
  }
  row["codec"]["id"] = cell.codec;
  row["codec"]["version"] = cell.codec_version;
  row["codec"]["parameters"] = cell.parameters.values();
  row["stage"] = cell.stage->id;
  row["threads"] = cell.threads.count;
  if (cell.render) {
    row["render"] = to_row(*cell.render);
    row["render"].erase("scene_path");
  }
  row["provenance"] = provenance;
  row["provenance"]["config_hash"] = config_hash;
  row["provenance"]["time"] = utc_now();
  return row;
}

std::string describe_end(const PlannedCell& planned, const Row& row) {
  const std::string status = row.at("status").get<std::string>();
  const std::string text = fmt::format("{}: {}", planned.cell.describe(), status);
  if (status != kOk) return fmt::format("{} ({})", text, row.at("reason").get<std::string>());
  const std::string headline = kind_of(planned.cell).headline(row);
  return fmt::format("{}{}{}, {} rounds", text, headline.empty() ? "" : ", ", headline,
                     row.at("time").at("rounds").get<std::uint64_t>());
}

void add_times(const PlannedCell& planned, const Measured& measured, const std::string& stop,
               Row& row) {
  Row& time = row["time"];
  time["rounds"] = measured.rounds;
  time["stop"] = stop;
  time["relative_interval"] = finite_or_null(measured.relative_interval());
  kind_of(planned.cell).add_times(measured, planned.location->info, row);
}

}  // namespace cvr::experiments
