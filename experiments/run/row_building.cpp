#include "experiments/run/row_building.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/results/error_row.hpp"
#include "experiments/results/provenance.hpp"
#include "experiments/run/frame_times.hpp"

namespace cvr::experiments {

namespace {

constexpr int kSchemaVersion = 1;

Row describe(const std::vector<double>& samples) {
  const Statistics s = summarize(samples);
  Row row;
  row["median"] = s.median;
  row["mad"] = s.mad;
  row["lower_quartile"] = s.lower_quartile;
  row["upper_quartile"] = s.upper_quartile;
  row["interval"] = {s.interval_low, s.interval_high};
  row["interval_coverage"] = s.interval_coverage;
  row["minimum"] = s.minimum;
  row["maximum"] = s.maximum;
  row["mean"] = s.mean;
  row["note"] = s.note();
  row["samples"] = samples;
  return row;
}

}  // namespace

void Measured::add(const std::vector<Sample>& samples) {
  for (const Sample& sample : samples) {
    auto at = std::ranges::find(series, sample.series, &Series::name);
    if (at == series.end())
      at = series.insert(series.end(), {sample.series, sample.count, {}, {}, {}});
    at->wall_seconds.push_back(sample.wall_seconds);
    at->cpu_seconds.push_back(sample.cpu_seconds);
    at->counts.push_back(sample.count);
  }
  ++rounds;
}

double Measured::relative_interval() const {
  if (series.empty()) return std::numeric_limits<double>::infinity();
  return summarize(series.front().wall_seconds).relative_interval();
}

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
  row["stage"] = name_of(cell.stage);
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
  const Row& time = row.at("time");
  const auto rounds = time.at("rounds").get<std::uint64_t>();
  switch (planned.cell.stage) {
    case Stage::kRender:
      return fmt::format("{}, {:.4g} ms a frame, {} rounds", text,
                         row.at("frames").at("mean_ms").get<double>(), rounds);
    case Stage::kRandomAccess:
      if (row.at("access").empty()) return text;
      return fmt::format("{}, {:.4g} ns a voxel", text,
                         row.at("access").at(0).at("ns_per_voxel").at("median").get<double>());
    default:
      return fmt::format("{}, {:.4g} s, {} rounds", text,
                         time.at("seconds").at("median").get<double>(), rounds);
  }
}

void add_times(const PlannedCell& planned, const Measured& measured, const std::string& stop,
               Row& row) {
  const volumes::VolumeInfo& info = planned.location->info;
  Row& time = row["time"];
  time["rounds"] = measured.rounds;
  time["stop"] = stop;
  time["relative_interval"] = finite_or_null(measured.relative_interval());
  if (planned.cell.stage != Stage::kRandomAccess) {
    const Measured::Series& series = measured.series.front();
    time["seconds"] = describe(series.wall_seconds);
    time["cpu_seconds"] = describe(series.cpu_seconds);
    if (planned.cell.stage == Stage::kRender) {
      row["frames"] = describe_frames(measured);
      if (const Row held = describe_held_frames(measured); !held.is_null())
        row["held"].update(held);
      return;
    }
    const double median = time["seconds"]["median"].get<double>();
    const double rate = median > 0 ? 1 / median : std::numeric_limits<double>::infinity();
    time["gb_per_s"] = finite_or_null(1e-9 * static_cast<double>(info.bytes()) * rate);
    time["mvoxel_per_s"] = finite_or_null(1e-6 * static_cast<double>(info.extent.voxels()) * rate);
    for (std::size_t step = 1; step < measured.series.size(); ++step)
      row["steps"][step - 1]["seconds"] = describe(measured.series[step].wall_seconds);
    return;
  }
  row["access"] = Row::array();
  for (const Measured::Series& series : measured.series) {
    const std::size_t slash = series.name.rfind('/');
    std::vector<double> ns, cpu_ns;
    for (const double s : series.wall_seconds)
      ns.push_back(1e9 * s / static_cast<double>(series.count));
    for (const double s : series.cpu_seconds)
      cpu_ns.push_back(1e9 * s / static_cast<double>(series.count));
    Row entry;
    entry["points"] = series.name.substr(0, slash);
    entry["lod"] = std::stoi(series.name.substr(slash + 1));
    entry["count"] = series.count;
    entry["ns_per_voxel"] = describe(ns);
    entry["cpu_ns_per_voxel"] = summarize(cpu_ns).median;
    row["access"].push_back(std::move(entry));
  }
}

}  // namespace cvr::experiments
