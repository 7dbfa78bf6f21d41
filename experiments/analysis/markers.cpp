#include "experiments/analysis/markers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "experiments/analysis/claims.hpp"
#include "experiments/analysis/metrics.hpp"
#include "experiments/analysis/table_formats.hpp"
#include "experiments/analysis/table_lines.hpp"
#include "experiments/analysis/tables.hpp"
#include "experiments/config/render_options.hpp"

namespace cvr::experiments {

namespace {

constexpr std::string_view kBegin = "<!--cvrbench", kBeginEnd = "-->", kEnd = "<!--/cvrbench-->";
constexpr std::uint64_t kRatioDecimals = 2;

/// A marker that cannot be filled; its place is added where it is known.
[[noreturn]] void fail(const std::string& message) { throw InputError(message); }

bool names_images(const Conditions& conditions) {
  return std::ranges::any_of(conditions, [](const auto& c) { return is_render_label(c.first); });
}

/// A figure of a line, as tables show it.
struct Found {
  std::string text;
  double number;
};

class Filler {
 public:
  Filler(const MarkerSpec& spec, const Evidence& evidence, MetricNames metrics)
      : spec_(spec),
        evidence_(evidence),
        metrics_(metrics),
        latest_(latest_by(evidence.rows, &Result::key)) {}

  std::string fill() const {
    if (!spec_.value.empty()) return one_figure();
    if (!spec_.least.empty()) return shown(extremes(spec_.least).first);
    if (!spec_.largest.empty()) return shown(extremes(spec_.largest).second);
    if (!spec_.range.empty()) {
      const auto [least, largest] = extremes(spec_.range);
      return fmt::format("{} to {}", shown(least), shown(largest));
    }
    if (!spec_.sum.empty()) return sum();
    if (!spec_.cells.empty()) return count_cells();
    if (!spec_.table.empty()) return table();
    if (!spec_.claim.empty()) return std::string(name_of(verdict_on(spec_.claim).verdict));
    if (!spec_.claims.empty()) return claims();
    return own_table();
  }

 private:
  std::vector<Found> figures(const std::string& metric, const Conditions& where) const {
    const Metric& read = *find_metric(metric);
    const bool renders = find_metric_name(metrics_, metric)->of_images || names_images(where);
    std::optional<PublishedTable> published;
    if (const auto& place = spec_.lines.published)
      published = load_published(place->file, place->table, place->scaled);
    std::vector<Found> all;
    for (const TableLine& line : collect_lines(Filter{where}, renders, evidence_.config, latest_)) {
      const Reading reading = read.read(context_of(line, published));
      if (reading.number) all.push_back({reading.text, *reading.number});
    }
    if (all.empty()) fail(fmt::format("expected a {} that it has, found none", metric));
    return all;
  }

  Found only_figure(const std::string& metric, const Conditions& where) const {
    const auto all = figures(metric, where);
    if (all.size() > 1)
      fail(fmt::format("expected one {}, found {} ({}, {}, ..): name more labels under where",
                       metric, all.size(), all[0].text, all[1].text));
    return all.front();
  }

  std::string shown(const Found& found) const {
    return spec_.decimals ? fmt::format("{:.{}f}", found.number, *spec_.decimals) : found.text;
  }

  std::string one_figure() const {
    const Found found = only_figure(spec_.value, spec_.where);
    if (spec_.over.empty()) return shown(found);
    const Found divisor = only_figure(spec_.value, spec_.over);
    return fmt::format("{:.{}f}", found.number / divisor.number,
                       spec_.decimals.value_or(kRatioDecimals));
  }

  std::pair<Found, Found> extremes(const std::string& metric) const {
    const auto all = figures(metric, spec_.where);
    const auto [least, largest] = std::ranges::minmax_element(all, {}, &Found::number);
    return {*least, *largest};
  }

  std::string sum() const {
    double total = 0;
    for (const Found& found : figures(spec_.sum, spec_.where)) total += found.number;
    return fmt::format("{:.{}f}", total, spec_.decimals.value_or(0));
  }

  std::string count_cells() const {
    const Filter filter{spec_.where};
    const auto count = std::ranges::count_if(evidence_.config.cells, [&](const Cell& cell) {
      const auto row = latest_.find(cell.row_key());
      return filter.keeps(cell) && row != latest_.end() && row->second.status == spec_.cells;
    });
    return std::to_string(count);
  }

  std::string table() const {
    const auto& tables = evidence_.config.tables;
    const auto found = std::ranges::find(tables, spec_.table, &TableSpec::name);
    if (found == tables.end()) fail(fmt::format("expected a table of it, found {}", spec_.table));
    TableSpec narrowed = *found;
    narrowed.where.insert(narrowed.where.end(), spec_.where.begin(), spec_.where.end());
    return lines_of(make_table(narrowed, evidence_.config, evidence_.rows));
  }

  std::string own_table() const {
    TableSpec lines = spec_.lines;
    lines.where = spec_.where;
    return lines_of(make_table(lines, evidence_.config, evidence_.rows));
  }

  /// The lines alone: what they mean is told by the text around them.
  static std::string lines_of(Table table) {
    table.notes.clear();
    const std::string text = render(table, TableFormat::kMarkdown);
    return "\n" + text.substr(text.find("\n\n") + 2);
  }

  std::vector<ClaimVerdict> verdicts() const {
    return judge_claims(evidence_.config, evidence_.rows);
  }

  ClaimVerdict verdict_on(const std::string& name) const {
    auto all = verdicts();
    const auto found =
        std::ranges::find_if(all, [&](const auto& v) { return v.claim->name == name; });
    if (found == all.end()) fail(fmt::format("expected a claim of it, found {}", name));
    return *found;
  }

  std::string claims() const {
    std::vector<ClaimVerdict> chosen;
    for (const std::string& name : spec_.claims) {
      if (name == "all") {
        for (ClaimVerdict& verdict : verdicts()) chosen.push_back(std::move(verdict));
      } else {
        chosen.push_back(verdict_on(name));
      }
    }
    return lines_of(claims_summary(chosen));
  }

  const MarkerSpec& spec_;
  const Evidence& evidence_;
  MetricNames metrics_;
  std::map<std::string, Result> latest_;
};

/// Whether a place of a text lies in code. `text` is read from its beginning on.
class Code {
 public:
  explicit Code(std::string_view text) : text_(text) {}
  bool holds(std::size_t place) {
    for (; line_ <= place; line_ = next_line()) {
      if (next_line() > place) break;
      toggle();
    }
    const std::string_view before = text_.substr(line_, place - line_);
    return fenced_ || std::ranges::count(before, '`') % 2 == 1;
  }

 private:
  std::size_t next_line() const {
    const std::size_t end = text_.find('\n', line_);
    return end == std::string_view::npos ? text_.size() + 1 : end + 1;
  }
  void toggle() {
    const std::string_view line = text_.substr(line_, next_line() - line_ - 1);
    const std::size_t first = line.find_first_not_of(' ');
    if (first != std::string_view::npos && line.substr(first).starts_with("```"))
      fenced_ = !fenced_;
  }

  std::string_view text_;
  std::size_t line_ = 0;
  bool fenced_ = false;
};

}  // namespace

std::string fill_markers(const std::string& path, const std::string& text,
                         const EvidenceSource& evidence, MetricNames metrics) {
  std::string filled;
  Code code(text);
  std::size_t done = 0;
  for (std::size_t at = 0; (at = text.find(kBegin, at)) != std::string::npos;) {
    if (code.holds(at)) {
      at += kBegin.size();
      continue;
    }
    const auto line = 1 + std::ranges::count(std::string_view(text).substr(0, at), '\n');
    const std::string place = fmt::format("{}:{}: marker", path, line);
    const std::size_t body = at + kBegin.size(), body_end = text.find(kBeginEnd, body);
    const std::size_t end = body_end == std::string::npos ? body_end : text.find(kEnd, body_end);
    const std::size_t next = text.find(kBegin, body);
    if (end == std::string::npos || next < end)
      throw InputError(fmt::format("{}: expected {} behind it, found none", place, kEnd));
    const MarkerSpec spec = read_marker(text.substr(body, body_end - body), place, path, metrics);
    filled.append(text, done, body_end + kBeginEnd.size() - done);
    try {
      filled += Filler(spec, evidence(spec.run), metrics).fill();
    } catch (const InputError& error) {
      throw InputError(fmt::format("{} of {}: {}", place, spec.run, error.what()));
    }
    done = end;
    at = end + kEnd.size();
  }
  return filled.append(text, done);
}

std::string evidence_page(const Evidence& evidence, const std::vector<std::string>& figures) {
  const Config& config = evidence.config;
  std::string text = evidence.readme;
  text += fmt::format(
      "\nRows: [results/evidence/{0}](../../results/evidence/{0}). This page is made from them by "
      "`scripts/make-docs`.\n",
      evidence.name);
  if (!figures.empty()) text += "\n## Figures\n\n";
  for (const std::string& figure : figures) text += fmt::format("![{0}]({0})\n", figure);
  for (const TableSpec& spec : config.tables) {
    const Table table = make_table(spec, config, evidence.rows);
    text += "\n#" + render(table, TableFormat::kMarkdown).substr(2);
  }
  if (config.claims.empty()) return text;
  const auto verdicts = judge_claims(config, evidence.rows);
  for (const Table& table : {claims_table(config, verdicts), groups_table(verdicts, true)})
    text += "\n#" + render(table, TableFormat::kMarkdown).substr(2);
  return text;
}

}  // namespace cvr::experiments
