#include "experiments/tracking/quantities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "experiments/tracking/json_shape.hpp"

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

void add_counted(const Row& row, const std::string& key, const std::string& name,
                 std::vector<Quantity>& out) {
  if (row.contains(key) && row.at(key).is_number()) {
    out.push_back(
        {.name = name, .kind = QuantityKind::kCounted, .number = row.at(key).get<double>()});
  }
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

std::vector<double> samples_in(const Row& statistics) {
  return statistics.value("samples", std::vector<double>{});
}

/// The mean of each round's frames.
std::vector<double> round_means(const Row& rounds) {
  std::vector<double> means;
  for (const Row& round : rounds) {
    const auto frames = round.get<std::vector<double>>();
    if (frames.empty()) continue;
    means.push_back(std::accumulate(frames.begin(), frames.end(), 0.0) /
                    static_cast<double>(frames.size()));
  }
  return means;
}

void add_times(const Row& row, std::vector<Quantity>& out) {
  const std::string stage = row.value("stage", "");
  if (stage == "encode" || stage == "decode" || stage == "label-statistics") {
    const std::string_view noise_class = stage == "encode" ? kNoiseClasses[0] : kNoiseClasses[1];
    add_time(samples_in(row.at("time").at("seconds")), stage, "s", noise_class, out);
    if (row.contains("steps")) {
      for (const Row& step : row.at("steps")) {
        if (step.contains("seconds"))
          add_time(samples_in(step.at("seconds")),
                   fmt::format("{} step {}", stage, step.value("name", "?")), "s", noise_class,
                   out);
      }
    }
  }
  if (row.contains("access")) {
    for (const Row& series : row.at("access")) {
      add_time(
          samples_in(series.at("ns_per_voxel")),
          fmt::format("access {} level {}", series.value("points", "?"), series.value("lod", 0)),
          "ns", kNoiseClasses[2], out);
    }
  }
  if (row.contains("frames"))
    add_time(round_means(row.at("frames").value("ms", Row::array())), "frame", "ms",
             kNoiseClasses[3], out);
  if (row.contains("held"))
    add_time(round_means(row.at("held").value("ms", Row::array())), "held frame", "ms",
             kNoiseClasses[4], out);
}

std::vector<Quantity> read_quantities(const Row& row) {
  std::vector<Quantity> all;
  if (row.value("status", "") != kOk) return all;
  for (const char* part : {"size", "error"}) {
    if (row.contains(part)) add_exact(row.at(part), part, all);
  }
  if (row.contains("verification")) {
    // How far a picture is from the reference depends on the device's arithmetic; wrong pixels and
    // voxels do not.
    for (const char* count :
         {"voxels_compared", "mismatches", "pixels_compared", "label_mismatches"}) {
      if (row.at("verification").contains(count)) {
        all.push_back({.name = fmt::format("verification.{}", count),
                       .kind = QuantityKind::kExact,
                       .number = row.at("verification").at(count).get<double>()});
      }
    }
  }
  if (row.contains("counters")) {
    for (const auto& [name, value] : row.at("counters").items())
      add_counted(row.at("counters"), name, "counters." + name, all);
  }
  if (row.contains("memory")) {
    add_counted(row.at("memory"), "gpu_bytes", "memory.gpu_bytes", all);
    add_counted(row.at("memory"), "peak_bytes", "memory.peak_bytes", all);
  }
  add_times(row, all);
  return all;
}

}  // namespace

std::vector<Quantity> quantities_of(const Row& row) {
  return expecting_shape("a row", "the fields of results/schema/row.schema.json",
                         [&] { return read_quantities(row); });
}

double tolerance_of(const Quantity& quantity) {
  if (quantity.kind == QuantityKind::kExact) return quantity.name.starts_with("error.") ? 1e-9 : 0;
  if (quantity.name == "memory.peak_bytes") return 0.1;
  return 0.01;
}

}  // namespace cvr::experiments
