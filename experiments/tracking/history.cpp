#include "experiments/tracking/history.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "experiments/results/statistics.hpp"
#include "volumes/error.hpp"
#include "volumes/io/file.hpp"
#include "volumes/json_text.hpp"

namespace cvr::experiments {

namespace {

namespace fs = std::filesystem;

constexpr double kCountedFloor = 0.01;

std::string identity_of(const Row& line) {
  return line.value("time", "") + "|" + line.value("revision", "") + "|" + line.value("key", "") +
         "|" + line.value("quantity", "");
}

/// Whether a line has the fields that make it a figure, and those it has are of their types.
bool is_figure(const Row& line) {
  if (!line.is_object() || !line.contains("value")) return false;
  for (const char* name : {"key", "quantity"}) {
    if (!line.contains(name)) return false;
  }
  for (const char* name :
       {"key", "quantity", "time", "revision", "codec", "kind", "unit", "class"}) {
    if (line.contains(name) && !line.at(name).is_string()) return false;
  }
  return true;
}

std::vector<Row> load_lines(const fs::path& path) {
  std::vector<Row> lines;
  std::ifstream in(path);
  std::string text;
  for (std::size_t n = 1; std::getline(in, text); ++n) {
    Row line = volumes::parse_json(text, path.string(), n);
    if (!is_figure(line))
      throw volumes::InputError(fmt::format(
          "{}:{}: expected a figure (an object with key, quantity and value), found '{}'",
          path.string(), n, text.substr(0, 40)));
    lines.push_back(std::move(line));
  }
  return lines;
}

bool is_fingerprint(const std::string& machine) {
  return !machine.empty() && machine.size() <= 100 &&
         std::ranges::all_of(
             machine, [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_'; });
}

Row figure_of(const Result& row, const Quantity& quantity) {
  Row line;
  line["time"] = row.provenance.time;
  line["revision"] = row.provenance.revision;
  line["key"] = row.key;
  line["codec"] = row.codec.id;
  line["version"] = row.codec.version;
  line["quantity"] = quantity.name;
  line["kind"] = name_of(quantity.kind);
  if (quantity.kind == QuantityKind::kTime) {
    const Statistics s = summarize(quantity.samples);
    line["unit"] = quantity.unit;
    line["class"] = quantity.noise_class;
    line["value"] = s.median;
    line["interval"] = {s.interval_low, s.interval_high};
    line["n"] = s.n;
  } else if (quantity.number) {
    line["value"] = *quantity.number;
  } else {
    line["value"] = quantity.text;
  }
  return line;
}

std::string value_text(const Row& line) {
  if (!line["value"].is_number()) return line["value"].dump();
  const std::string unit = line.value("unit", "");
  return fmt::format("{:.6g}{}{}", line["value"].get<double>(), unit.empty() ? "" : " ", unit);
}

HistoryStep step_at(const std::vector<const Row*>& series, std::size_t at,
                    const std::string& machine) {
  const Row& now = *series[at];
  HistoryStep step;
  step.key = now.at("key").get<std::string>();
  step.codec = now.value("codec", "");
  step.quantity = now["quantity"].get<std::string>();
  step.machine = machine;
  step.revision = now.value("revision", "");
  step.previous = series[at - 1]->value("revision", "");
  step.time = now.value("time", "");
  return step;
}

/// More is better of these.
bool wants_more(const std::string& quantity) { return quantity.find("psnr") != std::string::npos; }

void add_exact_steps(const std::vector<const Row*>& series, const std::string& machine,
                     std::vector<HistoryStep>& steps) {
  for (std::size_t i = 1; i < series.size(); ++i) {
    const Row &before = (*series[i - 1])["value"], &after = (*series[i])["value"];
    if (before == after) continue;
    HistoryStep step = step_at(series, i, machine);
    step.kind = QuantityKind::kExact;
    step.before = value_text(*series[i - 1]), step.after = value_text(*series[i]);
    step.worse = true;
    if (before.is_number() && after.is_number()) {
      const double from = before.get<double>(), to = after.get<double>();
      if (from != 0) step.ratio = to / from;
      step.worse = wants_more(step.quantity) ? to < from : to > from;
    }
    step.last = std::all_of(series.begin() + static_cast<std::ptrdiff_t>(i), series.end(),
                            [&](const Row* r) { return (*r)["value"] == after; });
    steps.push_back(std::move(step));
  }
}

void add_fitted_steps(const std::vector<const Row*>& series, QuantityKind kind, double floor,
                      const std::string& machine, std::vector<HistoryStep>& steps) {
  std::vector<double> figures;
  for (const Row* line : series) {
    const double value = (*line)["value"].is_number() ? (*line)["value"].get<double>() : 0;
    if (!(value > 0)) return;  // counts that may be 0 have no ratio
    figures.push_back(value);
  }
  const auto found = find_steps(figures, floor);
  for (std::size_t i = 0; i < found.size(); ++i) {
    HistoryStep step = step_at(series, found[i].at, machine);
    step.kind = kind;
    const std::string unit = series.front()->value("unit", "");
    step.before = fmt::format("{:.4g}{}{}", found[i].before, unit.empty() ? "" : " ", unit);
    step.after = fmt::format("{:.4g}{}{}", found[i].after, unit.empty() ? "" : " ", unit);
    step.ratio = found[i].ratio();
    step.worse = step.ratio > 1;
    step.last = i + 1 == found.size();
    steps.push_back(std::move(step));
  }
}

}  // namespace

Recorded record_history(const std::string& store, const std::vector<Result>& rows) {
  Recorded recorded;
  fs::create_directories(store);
  const volumes::FolderLock lock(store);
  std::map<std::string, std::string> fresh;  // text to append by machine
  std::map<std::string, std::set<std::string>> known;
  for (const auto& [key, row] : latest_by(rows, &Result::key)) {
    if (!row.is_ok()) continue;
    const std::string& machine = row.provenance.machine;
    if (!is_fingerprint(machine))
      throw volumes::InputError(fmt::format(
          "{}: expected a machine of letters, digits, - and _, which names a file, found '{}'", key,
          machine));
    if (!known.contains(machine)) {
      for (const Row& line : load_lines(fs::path(store) / (machine + ".jsonl")))
        known[machine].insert(identity_of(line));
    }
    bool any = false;
    for (const Quantity& quantity : quantities_of(row)) {
      const Row line = figure_of(row, quantity);
      if (!known[machine].insert(identity_of(line)).second) continue;
      fresh[machine] += line.dump() + "\n";
      ++recorded.figures;
      any = true;
    }
    recorded.rows += any;
  }
  for (const auto& [machine, text] : fresh) {
    const std::string path = (fs::path(store) / (machine + ".jsonl")).string();
    volumes::OutputFile file(path);
    if (fs::exists(path)) {
      const volumes::MappedFile old(path);
      file.write(old.text());
      if (!old.text().empty() && old.text().back() != '\n') file.write("\n");
    }
    file.write(text);
    file.commit();
  }
  return recorded;
}

History read_history(const std::string& store, const std::string& machine,
                     const std::string& noise_path) {
  History history;
  if (!fs::is_directory(store)) return history;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(store)) {
    if (entry.path().extension() == ".jsonl" && (machine.empty() || entry.path().stem() == machine))
      files.push_back(entry.path());
  }
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    const std::string here = file.stem().string();
    const NoiseFloors floors = load_floors(noise_path, here, Arrangement::kApart);
    std::vector<Row> lines = load_lines(file);
    std::ranges::stable_sort(lines, {}, [](const Row& line) { return line.value("time", ""); });
    std::map<std::string, std::vector<const Row*>> series;
    for (const Row& line : lines)
      series[line["key"].get<std::string>() + "|" + line["quantity"].get<std::string>()].push_back(
          &line);
    history.figures += lines.size();
    history.series += series.size();
    for (const auto& [name, figures] : series) {
      const std::string kind = figures.front()->value("kind", "exact");
      if (kind == "exact") {
        add_exact_steps(figures, here, history.steps);
      } else {
        const bool time = kind == "time";
        add_fitted_steps(figures, time ? QuantityKind::kTime : QuantityKind::kCounted,
                         time ? floors.of(figures.front()->value("class", "")) : kCountedFloor,
                         here, history.steps);
      }
    }
  }
  std::ranges::stable_sort(history.steps, {}, &HistoryStep::time);
  return history;
}

}  // namespace cvr::experiments
