#include "experiments/tracking/quantities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace cvr::experiments {

namespace {

/// Numbers and texts of an object and of the objects in it.
void add_exact(const Row& row, const std::string& name, std::vector<Quantity>& out) {
  for (const auto& [key, value] : row.items()) {
    const std::string full = name + "." + key;
    if (value.is_object()) {
      add_exact(value, full, out);
    } else if (value.is_number()) {
      out.push_back({.name = full, .kind = QuantityKind::kExact, .number = value.get<double>()});
    } else if (value.is_string() || value.is_boolean()) {
      out.push_back({.name = full, .kind = QuantityKind::kExact, .text = value.dump()});
    }
  }
}

void add_counted(const Count& count, const std::string& name, std::vector<Quantity>& out) {
  if (count)
    out.push_back(
        {.name = name, .kind = QuantityKind::kCounted, .number = static_cast<double>(*count)});
}

void add_time(std::vector<double> samples, const std::string& name, const char* unit,
              std::string_view noise_class, std::vector<Quantity>& out) {
  if (samples.empty() || !std::ranges::all_of(samples, [](double x) { return x > 0; })) return;
  out.push_back({.name = name,
                 .kind = QuantityKind::kTime,
                 .samples = std::move(samples),
                 .unit = unit,
                 .noise_class = noise_class});
}

/// The mean of each round's frames.
std::vector<double> round_means(const std::vector<std::vector<double>>& rounds) {
  std::vector<double> means;
  for (const auto& frames : rounds) {
    if (frames.empty()) continue;
    means.push_back(std::accumulate(frames.begin(), frames.end(), 0.0) /
                    static_cast<double>(frames.size()));
  }
  return means;
}

void add_times(const Result& row, std::vector<Quantity>& out) {
  const std::string& stage = row.stage;
  if (stage == "encode" || stage == "decode" || stage == "label-statistics") {
    const std::string_view noise_class = stage == "encode" ? kNoiseClasses[0] : kNoiseClasses[1];
    if (row.time && row.time->seconds)
      add_time(row.time->seconds->samples, stage, "s", noise_class, out);
    for (const Parts::Step& step : row.steps.value_or(std::vector<Parts::Step>())) {
      if (step.seconds)
        add_time(step.seconds->samples, fmt::format("{} step {}", stage, step.name), "s",
                 noise_class, out);
    }
  }
  for (const Parts::Access& series : row.access.value_or(std::vector<Parts::Access>())) {
    if (series.ns_per_voxel)
      add_time(series.ns_per_voxel->samples,
               fmt::format("access {} level {}", series.points, series.lod), "ns", kNoiseClasses[2],
               out);
  }
  if (row.frames) add_time(round_means(row.frames->ms), "frame", "ms", kNoiseClasses[3], out);
  if (row.held) add_time(round_means(row.held->ms), "held frame", "ms", kNoiseClasses[4], out);
}

}  // namespace

std::vector<Quantity> quantities_of(const Result& row) {
  std::vector<Quantity> all;
  if (!row.is_ok()) return all;
  if (row.size) add_exact(to_json(*row.size), "size", all);
  if (row.error) add_exact(to_json(*row.error), "error", all);
  if (row.verification) {
    // How far an image is from the reference depends on the device's arithmetic; wrong pixels and
    // voxels do not.
    const Row verification = to_json(*row.verification);
    for (const char* count :
         {"voxels_compared", "mismatches", "pixels_compared", "label_mismatches"}) {
      if (const auto found = verification.find(count); found != verification.end())
        add_exact({{count, *found}}, "verification", all);
    }
  }
  for (const auto& [name, count] : row.counters.value_or(Named<std::uint64_t>()))
    add_counted(count, "counters." + name, all);
  if (row.memory) {
    add_counted(row.memory->gpu_bytes, "memory.gpu_bytes", all);
    add_counted(row.memory->peak_bytes, "memory.peak_bytes", all);
  }
  add_times(row, all);
  return all;
}

double tolerance_of(const Quantity& quantity) {
  if (quantity.kind == QuantityKind::kExact) return quantity.name.starts_with("error.") ? 1e-9 : 0;
  if (quantity.name == "memory.peak_bytes") return 0.1;
  return 0.01;
}

}  // namespace cvr::experiments
