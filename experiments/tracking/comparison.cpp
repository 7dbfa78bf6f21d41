#include "experiments/tracking/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/analysis/escaping.hpp"
#include "experiments/results/statistics.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments {

namespace {

constexpr std::array kAllOutcomes{Outcome::kSame,      Outcome::kFaster,     Outcome::kSlower,
                                  Outcome::kUndecided, Outcome::kDiffers,    Outcome::kMore,
                                  Outcome::kLess,      Outcome::kNotCompared};

std::vector<double> ascending(std::span<const double> samples) {
  std::vector<double> sorted(samples.begin(), samples.end());
  std::ranges::sort(sorted);
  return sorted;
}

std::string percent(double ratio) { return fmt::format("{:+.1f} %", 100 * (ratio - 1)); }

std::string mode_of(const Result& row) {
  const std::string access = row.access_mode();
  return access.empty() ? row.stage : access;
}

/// The device that drew, "" for other stages: software devices of two versions are two machines.
std::string device_of(const Result& row) {
  return row.device ? row.device->driver + row.device->name : "";
}

void judge_numbers(ComparedQuantity& c) {
  if (!c.base.number || !c.fresh.number) {
    c.outcome = c.base.text == c.fresh.text ? Outcome::kSame : Outcome::kDiffers;
    if (c.outcome == Outcome::kDiffers)
      c.reason = fmt::format("{} -> {}", c.base.text, c.fresh.text);
    return;
  }
  const double from = *c.base.number, to = *c.fresh.number;
  c.ratio = from == to ? 1 : from == 0 ? HUGE_VAL : to / from;
  c.floor = tolerance_of(c.base);
  const bool near = std::abs(to - from) <= c.floor * std::max(std::abs(from), std::abs(to));
  const bool exact = c.base.kind == QuantityKind::kExact;
  c.outcome = near        ? Outcome::kSame
              : exact     ? Outcome::kDiffers
              : to > from ? Outcome::kMore
                          : Outcome::kLess;
  if (!near) c.reason = fmt::format("{:.17g} -> {:.17g}", from, to);
}

class Comparer {
 public:
  explicit Comparer(const CompareOptions& options) : options_(options) {}

  void compare(const Result& base, const Result& fresh) {
    if (base.is_ok() && fresh.is_ok()) ++report.measured;
    if (base.status != fresh.status || !base.is_ok()) {
      ComparedQuantity c =
          start(base, {.name = "status", .kind = QuantityKind::kExact, .text = base.status},
                {.name = "status", .kind = QuantityKind::kExact, .text = fresh.status});
      judge_numbers(c);
      if (c.outcome == Outcome::kDiffers && !fresh.is_ok())
        c.reason += fmt::format(" ({})", fresh.reason);
      report.comparisons.push_back(std::move(c));
      return;
    }
    const std::string why_not = why_times_do_not_compare(base, fresh);
    const std::vector<Quantity> from = quantities_of(base), to = quantities_of(fresh);
    for (const Quantity& quantity : from) {
      const auto partner = std::ranges::find(to, quantity.name, &Quantity::name);
      ComparedQuantity c = start(
          base, quantity,
          partner == to.end() ? Quantity{.name = quantity.name, .kind = quantity.kind} : *partner);
      if (partner == to.end()) {
        c.outcome = Outcome::kNotCompared;
        c.reason = "the new row does not have it";
      } else if (quantity.kind == QuantityKind::kTime) {
        judge_time(c, why_not);
      } else {
        judge_numbers(c);
      }
      report.comparisons.push_back(std::move(c));
    }
  }

  CompareReport report;

 private:
  ComparedQuantity start(const Result& row, Quantity base, Quantity fresh) const {
    ComparedQuantity c;
    c.key = row.key;
    c.codec = row.codec.id;
    c.mode = mode_of(row);
    c.base = std::move(base);
    c.fresh = std::move(fresh);
    return c;
  }

  std::string why_times_do_not_compare(const Result& base, const Result& fresh) {
    std::string why;
    if (base.cell != fresh.cell)
      why = "the cells have another identity (data, codec version or parameters)";
    else if (base.provenance.machine != fresh.provenance.machine)
      why = fmt::format("measured on the machines {} and {}", base.provenance.machine,
                        fresh.provenance.machine);
    else if (device_of(base) != device_of(fresh))
      why = "drawn by two devices or drivers";
    if (!why.empty()) remark("Times of some cells are not compared: " + why + ".");
    return why;
  }

  void judge_time(ComparedQuantity& c, const std::string& why_not) {
    if (!why_not.empty()) {
      c.outcome = Outcome::kNotCompared;
      c.reason = why_not;
      return;
    }
    c.floor = options_.floors.of(c.base.noise_class);
    if (!options_.floors.knows(c.base.noise_class)) {
      remark(
          fmt::format("No noise floor of '{}' is known on this machine, {:.0f} % is assumed: "
                      "measure it with `cvrbench aa`.",
                      c.base.noise_class, 100 * kAssumedFloor));
    }
    const TimeVerdict verdict =
        judge_times(c.base.samples, c.fresh.samples, c.floor, options_.paired);
    c.outcome = verdict.outcome;
    c.ratio = verdict.estimate.ratio, c.low = verdict.estimate.low, c.high = verdict.estimate.high;
    c.p = verdict.p;
    c.gap = verdict.gap;
    c.reason = verdict.reason;
  }

  void remark(std::string text) {
    if (std::ranges::find(report.remarks, text) == report.remarks.end())
      report.remarks.push_back(std::move(text));
  }

  const CompareOptions& options_;
};

std::string figures_of(const ComparedQuantity& c) {
  if (c.base.kind == QuantityKind::kTime && c.outcome != Outcome::kNotCompared) {
    return fmt::format("{:.4g} -> {:.4g} {}, {} [{}, {}]", summarize(c.base.samples).median,
                       summarize(c.fresh.samples).median, c.base.unit, percent(c.ratio),
                       percent(c.low), std::isfinite(c.high) ? percent(c.high) : "?");
  }
  return c.base.number && c.fresh.number && c.ratio != 1 ? percent(c.ratio) : "";
}

std::string ratio_text(double ratio) { return ratio == 0 ? "" : fmt::format("{:.3f}", ratio); }

}  // namespace

TimeVerdict judge_times(std::span<const double> base, std::span<const double> fresh, double floor,
                        bool paired) {
  TimeVerdict verdict{Outcome::kUndecided,
                      paired ? paired_ratio(base, fresh) : ratio_of(base, fresh), 1, 0, ""};
  double lower,
      upper;  // how far the quartile ranges lie apart: new over base, upwards and downwards
  if (paired) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < base.size(); ++i) ratios.push_back(fresh[i] / base[i]);
    std::ranges::sort(ratios);
    lower = quantile(ratios, 0.25), upper = quantile(ratios, 0.75);
    verdict.p = sign_test_p(base, fresh);
  } else {
    const auto from = ascending(base), to = ascending(fresh);
    lower = quantile(to, 0.25) / quantile(from, 0.75),
    upper = quantile(to, 0.75) / quantile(from, 0.25);
    verdict.p = mann_whitney_p(base, fresh);
  }
  const RatioEstimate& estimate = verdict.estimate;
  verdict.gap = std::max({0.0, lower - 1, 1 / upper - 1});
  const bool apart_up = lower > 1 + floor, apart_down = upper < 1 / (1 + floor);
  const double margin = std::max(floor, kSameMargin);
  const char* ranges = paired ? "the quartiles of the ratios lie" : "the quartile ranges lie";
  if ((apart_up || apart_down) && verdict.p < kSignificance) {
    verdict.outcome = apart_up ? Outcome::kSlower : Outcome::kFaster;
    verdict.reason =
        fmt::format("{} beyond the floor of {:.1f} %, p = {:.2g}", ranges, 100 * floor, verdict.p);
  } else if (estimate.coverage > 0 && estimate.low >= 1 / (1 + margin) &&
             estimate.high <= 1 + margin) {
    verdict.outcome = Outcome::kSame;
    verdict.reason = fmt::format("the interval of the ratio lies within {:.1f} %", 100 * margin);
  } else if (apart_up || apart_down) {
    verdict.reason = fmt::format("{} beyond the floor, but p = {:.2g} is not below {}: more rounds",
                                 ranges, verdict.p, kSignificance);
  } else {
    verdict.reason =
        estimate.coverage == 0
            ? "too few rounds for an interval"
            : fmt::format(
                  "the interval of the ratio leaves {:.1f} %, but {} within the floor of {:.1f} %",
                  100 * margin, ranges, 100 * floor);
  }
  return verdict;
}

std::size_t CompareReport::count(Outcome outcome) const {
  return static_cast<std::size_t>(
      std::ranges::count(comparisons, outcome, &ComparedQuantity::outcome));
}

CompareReport compare_rows(const std::vector<Result>& base, const std::vector<Result>& fresh,
                           const CompareOptions& options) {
  const auto from = latest_by(base, &Result::key), to = latest_by(fresh, &Result::key);
  Comparer comparer(options);
  std::set<std::string> seen;
  for (const Result& row : base) {  // in the order of the file, each key once
    if (!seen.insert(row.key).second) continue;
    const Result& last = from.at(row.key);
    if (const auto partner = to.find(row.key); partner != to.end()) {
      comparer.compare(last, partner->second);
    } else if (last.is_ok()) {
      comparer.report.only_in_base.push_back(row.key);
    }
  }
  for (const auto& [key, row] : to) {
    if (!from.contains(key) && row.is_ok()) comparer.report.only_in_new.push_back(key);
  }
  return std::move(comparer.report);
}

std::vector<CompareSummary> summarise(const CompareReport& report) {
  std::vector<CompareSummary> lines;
  struct Sums {
    double time = 0, size = 0;
    std::size_t times = 0, sizes = 0;
    std::set<std::string> keys;
  };
  std::vector<Sums> sums;
  for (const ComparedQuantity& c : report.comparisons) {
    auto line = std::ranges::find_if(
        lines, [&](const CompareSummary& s) { return s.codec == c.codec && s.mode == c.mode; });
    if (line == lines.end()) {
      lines.push_back({c.codec, c.mode});
      sums.emplace_back();
      line = lines.end() - 1;
    }
    Sums& sum = sums[static_cast<std::size_t>(line - lines.begin())];
    sum.keys.insert(c.key);
    ++line->counts[static_cast<std::size_t>(c.outcome)];
    if (c.base.kind == QuantityKind::kTime && c.outcome != Outcome::kNotCompared)
      sum.time += std::log(c.ratio), ++sum.times;
    if (c.base.name == "size.bytes" && std::isfinite(c.ratio) && c.ratio > 0)
      sum.size += std::log(c.ratio), ++sum.sizes;
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    lines[i].cells = sums[i].keys.size();
    if (sums[i].times > 0)
      lines[i].time_ratio = std::exp(sums[i].time / static_cast<double>(sums[i].times));
    if (sums[i].sizes > 0)
      lines[i].size_ratio = std::exp(sums[i].size / static_cast<double>(sums[i].sizes));
  }
  return lines;
}

std::string describe(const CompareReport& report, bool explain) {
  std::string text =
      "| codec | mode | cells | time new/base | size new/base | outcomes "
      "|\n|---|---|---:|---:|---:|---|\n";
  for (const CompareSummary& line : summarise(report)) {
    std::string counts;
    for (const Outcome outcome : kAllOutcomes) {
      if (const std::size_t count = line.counts[static_cast<std::size_t>(outcome)]; count > 0)
        counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, name_of(outcome));
    }
    text += fmt::format("| {} | {} | {} | {} | {} | {} |\n", escape_markdown(line.codec),
                        escape_markdown(line.mode), line.cells, ratio_text(line.time_ratio),
                        ratio_text(line.size_ratio), counts);
  }
  std::string last;
  for (const ComparedQuantity& c : report.comparisons) {
    if (!explain && (c.outcome == Outcome::kSame || c.outcome == Outcome::kUndecided ||
                     c.outcome == Outcome::kNotCompared))
      continue;
    if (c.key != last) text += fmt::format("\n{}\n", escape_markdown(c.key, false));
    last = c.key;
    const std::string figures = figures_of(c);
    text += fmt::format(
        "- **{}** {}{}{}{}{}\n", name_of(c.outcome), escape_markdown(c.base.name, false),
        figures.empty() && c.reason.empty() ? "" : ": ", figures,
        figures.empty() || c.reason.empty() ? "" : "; ", escape_markdown(c.reason, false));
  }
  for (const auto& [keys, where] : {std::pair{&report.only_in_base, "the base"},
                                    std::pair{&report.only_in_new, "the new rows"}}) {
    if (!keys->empty())
      text +=
          fmt::format("\n{} cells are only in {}{}\n", keys->size(), where, explain ? ":" : ".");
    if (explain)
      for (const std::string& key : *keys)
        text += fmt::format("- {}\n", escape_markdown(key, false));
  }
  if (!report.remarks.empty()) text += '\n';
  for (const std::string& remark : report.remarks) text += volumes::printable(remark) + "\n";
  return text;
}

std::vector<Row> compare_to_rows(const CompareReport& report) {
  const auto number = [](double value) { return std::isfinite(value) ? Row(value) : Row(nullptr); };
  std::vector<Row> rows;
  for (const ComparedQuantity& c : report.comparisons) {
    Row row{{"key", c.key},
            {"codec", c.codec},
            {"mode", c.mode},
            {"quantity", c.base.name},
            {"kind", name_of(c.base.kind)}};
    row["outcome"] = name_of(c.outcome);
    row["ratio"] = number(c.ratio);
    if (c.base.kind == QuantityKind::kTime) {
      row["interval"] = {number(c.low), number(c.high)};
      row["p"] = c.p;
    } else if (c.base.number && c.fresh.number) {
      row["base"] = *c.base.number, row["new"] = *c.fresh.number;
    }
    row["floor"] = c.floor;
    row["reason"] = c.reason;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace cvr::experiments
