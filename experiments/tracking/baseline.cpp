#include "experiments/tracking/baseline.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "experiments/tracking/quantities.hpp"
#include "volumes/error.hpp"
#include "volumes/io/file.hpp"
#include "volumes/json_text.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments {

namespace {

namespace fs = std::filesystem;

/// Sums of many doubles: the last digits depend on the compiler, and a file of differences should
/// not.
constexpr double kErrorDigits = 1e9;

Row rounded(const Quantity& quantity) {
  if (!quantity.number) return Row::parse(quantity.text);
  const double value = *quantity.number;
  if (value == std::floor(value) && std::abs(value) < 0x1p53)
    return static_cast<std::int64_t>(value);
  const double scale = kErrorDigits / std::pow(10.0, std::ceil(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

bool agree(const Row& a, const Row& b) {
  if (!a.is_number() || !b.is_number()) return a == b;
  const double x = a.get<double>(), y = b.get<double>();
  if (a.is_number_integer() && b.is_number_integer()) return x == y;
  return std::abs(x - y) <= 4 / kErrorDigits * std::max(std::abs(x), std::abs(y));
}

/// Rates follow from sizes, and gzip's and xz's are those of libraries.
bool belongs(const Quantity& quantity) {
  if (quantity.kind != QuantityKind::kExact) return false;
  static const std::set<std::string> kFollow{
      "size.rate",    "size.published_rate",     "size.bits_per_voxel",           "size.rate_gzip",
      "size.rate_xz", "size.gpu_bits_per_voxel", "size.published_bytes_per_voxel"};
  return !kFollow.contains(quantity.name);
}

}  // namespace

Baseline baseline_of(const Config& config, const std::vector<Result>& rows) {
  Baseline baseline{fs::path(config.path).stem().string(), {}};
  std::set<std::string> keys;
  for (const Cell& cell : config.cells) keys.insert(cell.row_key());
  for (const auto& [key, row] : latest_by(rows, &Result::key)) {
    if (!keys.contains(key)) continue;
    std::map<std::string, Row> figures;
    if (!row.is_ok()) figures["status"] = row.status;
    for (const Quantity& quantity : quantities_of(row)) {
      if (belongs(quantity)) figures[quantity.name] = rounded(quantity);
    }
    if (!figures.empty()) baseline.cells[key] = std::move(figures);  // memcpy has none
  }
  return baseline;
}

std::string baseline_path(const std::string& folder, const Config& config) {
  const fs::path name = fs::path(config.path).stem().string() + ".json";
  if (!folder.empty()) return (fs::path(folder) / name).string();
  for (fs::path above = fs::absolute(config.path).parent_path(); above.has_relative_path();
       above = above.parent_path()) {
    if (above.filename() == "configs")
      return (above.parent_path() / "results/baseline" / name).string();
  }
  return (fs::path("results/baseline") / name).string();
}

Baseline load_baseline(const std::string& path) {
  if (!fs::exists(path))
    throw volumes::InputError(
        fmt::format("{}: expected a baseline, found no file: 'baseline update' writes it", path));
  const Row file = volumes::read_json_file(path);
  if (!file.is_object() || !file.contains("cells") || !file["cells"].is_object() ||
      !file.value("config", Row("")).is_string())
    throw volumes::InputError(
        fmt::format("{}: expected an object with the object 'cells' and the text 'config'", path));
  Baseline baseline{file.value("config", ""), {}};
  for (const auto& [key, figures] : file["cells"].items()) {
    if (!figures.is_object())
      throw volumes::InputError(fmt::format("{}: {}: expected an object of figures, found {}", path,
                                            key, figures.type_name()));
    for (const auto& [quantity, value] : figures.items()) baseline.cells[key][quantity] = value;
  }
  return baseline;
}

void store_baseline(const std::string& path, const Baseline& baseline) {
  Row file;
  file["config"] = baseline.config;
  file["cells"] = Row::object();
  for (const auto& [key, figures] : baseline.cells) {
    Row& cell = file["cells"][key];
    for (const auto& [quantity, value] : figures) cell[quantity] = value;
  }
  fs::create_directories(fs::path(path).parent_path());
  volumes::write_whole_file(path, file.dump(1) + "\n");
}

BaselineReport compare_baselines(const Baseline& expected, const Baseline& found) {
  BaselineReport report;
  for (const auto& [key, figures] : expected.cells) {
    const auto cell = found.cells.find(key);
    if (cell == found.cells.end()) {
      report.missing.push_back(key);
      continue;
    }
    ++report.cells;
    std::set<std::string> quantities;
    for (const auto& [quantity, value] : figures) quantities.insert(quantity);
    for (const auto& [quantity, value] : cell->second) quantities.insert(quantity);
    for (const std::string& quantity : quantities) {
      const auto a = figures.find(quantity), b = cell->second.find(quantity);
      ++report.figures;
      if (a != figures.end() && b != cell->second.end() && agree(a->second, b->second)) continue;
      report.differences.push_back({key, quantity,
                                    a == figures.end() ? "nothing" : a->second.dump(),
                                    b == cell->second.end() ? "nothing" : b->second.dump()});
    }
  }
  for (const auto& [key, figures] : found.cells) {
    if (!expected.cells.contains(key)) report.added.push_back(key);
  }
  return report;
}

std::string describe(const BaselineReport& report, const std::string& path) {
  std::string text, last;
  for (const BaselineDifference& d : report.differences) {
    if (d.key != last) text += volumes::printable(d.key) + "\n";
    last = d.key;
    text += fmt::format("  {}: {} -> {}\n", volumes::printable(d.quantity),
                        volumes::printable(d.expected), volumes::printable(d.found));
  }
  for (const std::string& key : report.missing)
    text += fmt::format("{}\n  is in the baseline and was not measured\n", volumes::printable(key));
  for (const std::string& key : report.added)
    text += fmt::format("{}\n  is not in the baseline\n", volumes::printable(key));
  text += fmt::format("{}: {} figures of {} cells compared, {} differ", path, report.figures,
                      report.cells, report.differences.size());
  if (!report.missing.empty()) text += fmt::format(", {} cells missing", report.missing.size());
  if (!report.added.empty()) text += fmt::format(", {} cells added", report.added.size());
  return text + (report.differs() ? "; 'baseline update' writes what was found\n" : "\n");
}

}  // namespace cvr::experiments
