#include "experiments/tracking/export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "experiments/analysis/csv.hpp"
#include "experiments/results/statistics.hpp"
#include "experiments/tracking/quantities.hpp"

namespace cvr::experiments {

namespace {

double nanoseconds_of(const std::string& unit) {
  return unit == "s" ? 1e9 : unit == "ms" ? 1e6 : 1;
}

/// The key of a row as a path, the stage left to the kind of time.
std::string name_of_row(const Result& row) {
  std::string name = row.key;
  std::ranges::replace(name, '|', '/');
  return name.substr(0, name.rfind('/'));
}

std::vector<double> cpu_samples(const Result& row, const Quantity& quantity) {
  if (quantity.name != row.stage || !row.time || !row.time->cpu_seconds) return {};
  return row.time->cpu_seconds->samples;
}

Row entry(const std::string& name, std::size_t threads, std::size_t repetitions, double real,
          double cpu) {
  return {{"name", name},
          {"run_name", name},
          {"run_type", "iteration"},
          {"repetitions", repetitions},
          {"threads", threads},
          {"iterations", 1},
          {"real_time", real},
          {"cpu_time", cpu},
          {"time_unit", "ns"}};
}

double deviation(const std::vector<double>& samples, double mean) {
  double sum = 0;
  for (const double x : samples) sum += (x - mean) * (x - mean);
  return samples.size() < 2 ? 0 : std::sqrt(sum / static_cast<double>(samples.size() - 1));
}

void add_aggregates(const std::string& name, std::size_t threads, const std::vector<double>& real,
                    const std::vector<double>& cpu, Row& benchmarks) {
  const Statistics r = summarize(real), c = summarize(cpu);
  const double real_deviation = deviation(real, r.mean), cpu_deviation = deviation(cpu, c.mean);
  const auto add = [&](const char* aggregate, double of_real, double of_cpu,
                       const char* unit = "time") {
    Row row = entry(fmt::format("{}_{}", name, aggregate), threads, real.size(), of_real, of_cpu);
    row["run_name"] = name;
    row["run_type"] = "aggregate";
    row["aggregate_name"] = aggregate;
    row["aggregate_unit"] = unit;
    row["iterations"] = real.size();
    benchmarks.push_back(std::move(row));
  };
  add("mean", r.mean, c.mean);
  add("median", r.median, c.median);
  add("stddev", real_deviation, cpu_deviation);
  add("cv", r.mean > 0 ? real_deviation / r.mean : 0, c.mean > 0 ? cpu_deviation / c.mean : 0,
      "percentage");
}

void add_counters(const Result& row, Row& benchmark) {
  if (row.size && row.size->bytes) benchmark["bytes"] = *row.size->bytes;
  if (row.size && row.size->bits_per_voxel) benchmark["bits_per_voxel"] = *row.size->bits_per_voxel;
  if (row.error && row.error->psnr_db) benchmark["psnr_db"] = *row.error->psnr_db;
}

Row context_of(const Provenance& provenance) {
  return {{"date", provenance.time},  {"host_name", provenance.machine},
          {"executable", "cvrbench"}, {"num_cpus", provenance.cores},
          {"mhz_per_cpu", 0},         {"cpu_scaling_enabled", false},
          {"caches", Row::array()},   {"library_build_type", "release"},
          {"cpu", provenance.cpu},    {"revision", provenance.revision}};
}

/// An entry a sample of a time, and the aggregates.
void add_benchmarks(const Result& row, const Quantity& quantity, Row& benchmarks) {
  const std::string name = name_of_row(row) + "/" + quantity.name;
  std::vector<double> real, cpu = cpu_samples(row, quantity);
  for (const double x : quantity.samples) real.push_back(x * nanoseconds_of(quantity.unit));
  for (double& x : cpu) x *= nanoseconds_of(quantity.unit);
  if (cpu.size() != real.size()) cpu = real;
  for (std::size_t i = 0; i < real.size(); ++i) {
    Row one = entry(name, row.threads, real.size(), real[i], cpu[i]);
    one["repetition_index"] = i;
    add_counters(row, one);
    benchmarks.push_back(std::move(one));
  }
  add_aggregates(name, row.threads, real, cpu, benchmarks);
}

/// Calls visit(place, value) for everything that is no object and no list.
template <class F>
void walk(const Row& row, const std::string& place, const F& visit) {
  for (const auto& [key, value] : row.items()) {
    const std::string here = place.empty() ? key : place + "." + key;
    if (value.is_object())
      walk(value, here, visit);
    else if (!value.is_array())
      visit(here, value);
  }
}

std::string text_of(const Row& value) {
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace

Row to_google_benchmark(const std::vector<Result>& rows) {
  Row file;
  file["context"] = Row::object();
  file["benchmarks"] = Row::array();
  const auto latest = latest_by(rows, &Result::key);
  std::set<std::string> seen;
  for (const Result& any : rows) {
    if (!seen.insert(any.key).second) continue;
    const Result& row = latest.at(any.key);
    if (!row.is_ok()) continue;
    if (file["context"].empty()) file["context"] = context_of(row.provenance);
    for (const Quantity& quantity : quantities_of(row)) {
      if (quantity.kind == QuantityKind::kTime) add_benchmarks(row, quantity, file["benchmarks"]);
    }
  }
  return file;
}

std::string to_csv(const std::vector<Result>& rows) {
  std::vector<std::vector<std::string>> lines(1);
  std::map<std::string, std::size_t> places;
  for (const Result& row : rows) {
    std::map<std::size_t, std::string> fields;
    walk(to_json(row), "", [&](const std::string& place, const Row& value) {
      const auto [column, added] = places.emplace(place, lines[0].size());
      if (added) lines[0].push_back(place);
      fields[column->second] = text_of(value);
    });
    lines.emplace_back();
    for (const auto& [column, text] : fields) {
      lines.back().resize(column);
      lines.back().push_back(text);
    }
  }
  for (auto& line : lines) line.resize(places.size());
  return csv_text(lines, "\r\n");
}

}  // namespace cvr::experiments
