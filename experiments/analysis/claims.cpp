#include "experiments/analysis/claims.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/analysis/rate_distortion.hpp"
#include "experiments/analysis/render_metrics.hpp"
#include "experiments/analysis/table_lines.hpp"

namespace cvr::experiments {

namespace {

constexpr std::array kVerdicts{Verdict::kHolds, Verdict::kDoesNotHold, Verdict::kUndecided,
                               Verdict::kUnchecked};
constexpr double kRounding =
    1e-12;  ///< relative: decimal figures at a bound must not fail for their binary digits

/// The lines of one group, side by side.
struct Group {
  std::vector<std::string> labels;
  std::vector<std::vector<TableLine>> sides;
};

std::vector<Group> collect_groups(const ClaimSpec& claim, const Config& config,
                                  const std::map<std::string, Result>& latest) {
  std::vector<Group> groups;
  for (TableLine& line : collect_lines(Filter{claim.where}, claim.renders, config, latest)) {
    if (line.cell->codec == kMemcpy) continue;
    std::vector<std::string> labels;
    for (const std::string& key : claim.each) labels.push_back(label_of(*line.cell, key));
    for (std::size_t side = 0; side < claim.sides.size(); ++side) {
      if (!Filter{claim.sides[side].conditions}.keeps(*line.cell)) continue;
      auto group = std::ranges::find(groups, labels, &Group::labels);
      if (group == groups.end())
        group = groups.insert(groups.end(),
                              {labels, std::vector<std::vector<TableLine>>(claim.sides.size())});
      group->sides[side].push_back(line);
    }
  }
  return groups;
}

std::string describe(const std::vector<std::string>& labels) {
  return labels.empty() ? "" : fmt::format(" in the group {}", fmt::join(labels, " "));
}

/// Why a line has no figure.
std::string why_missing(const TableLine& line, const std::string& metric) {
  std::string name = line.cell->codec;
  if (const std::string values = line.cell->changes(); !values.empty()) name += " " + values;
  if (line.cell->render) name += " " + line.cell->render->access;
  bool ran = false;
  for (const auto& [stage, row] : line.rows) {
    if (row == nullptr) continue;
    ran = true;
    if (!row->is_ok()) return fmt::format("{} {}: {} ({})", name, stage, row->status, row->reason);
  }
  return ran ? fmt::format("{} has no {}", name, metric) : fmt::format("{} has not been run", name);
}

Verdict judge(const ClaimSpec& claim, const Interval& interval) {
  const auto slack = [](double bound) {
    return std::isfinite(bound) ? kRounding * std::max(1.0, std::abs(bound)) : 0;
  };
  const double least = claim.at_least - claim.tolerance - slack(claim.at_least);
  const double most = claim.at_most + claim.tolerance + slack(claim.at_most);
  if (interval.low >= least && interval.high <= most) return Verdict::kHolds;
  return interval.high < least || interval.low > most ? Verdict::kDoesNotHold : Verdict::kUndecided;
}

std::string text_of(const Reading& reading) {
  std::string text =
      reading.number && !reading.timed ? fmt::format("{:.6g}", *reading.number) : reading.text;
  if (reading.interval)
    text += fmt::format(" [{:.4g}, {:.4g}]", reading.interval->low, reading.interval->high);
  return text;
}

Interval whole(const Reading& reading) {
  return reading.interval.value_or(Interval{*reading.number, *reading.number});
}

/// Of one group: one comparison, or of an order one after the other.
class GroupJudge {
 public:
  GroupJudge(const ClaimSpec& claim, const Group& group,
             const std::optional<PublishedTable>& published)
      : claim_(claim), group_(group), published_(published), metric_(*find_metric(claim.metric)) {
    result_.labels = group.labels;
    for (const auto& side : group.sides) add_cells(side);
    result_.fitted =
        !claim.fitted.empty() && Filter{claim.fitted}.keeps(*group.sides.front().front().cell);
  }

  GroupVerdict judge_group() {
    if (claim_.over.empty()) {
      judge_figures();
    } else {
      judge_curves();
    }
    if (result_.verdict == Verdict::kUnchecked) result_.compared.clear();
    return std::move(result_);
  }

 private:
  /// The rows from which alone the metric has its number.
  void add_cells(const std::vector<TableLine>& lines) {
    for (const TableLine& line : lines) {
      for (const auto& [stage, row] : line.rows) {
        if (row != nullptr && metric_.read(context_of({line.cell, only(stage, row)}, {})).number)
          result_.cells.push_back(row->cell);
      }
    }
  }
  static StageRows only(std::string_view stage, const Result* row) {
    StageRows rows;
    rows[stage] = row;
    return rows;
  }
  static std::optional<Interval> interval_if(const Interval& interval, bool there) {
    return there ? std::optional(interval) : std::nullopt;
  }
  static bool lacks_interval(const Reading& reading) { return reading.timed && !reading.interval; }

  void judge_figures() {
    std::vector<Reading> readings;
    for (const auto& side : group_.sides) {
      readings.push_back(metric_.read(context_of(side.front(), published_)));
      if (!readings.back().number)
        return add_verdict(Verdict::kUnchecked, why_missing(side.front(), claim_.metric));
    }
    if (claim_.value) readings.push_back({fmt::format("{:.6g}", *claim_.value), *claim_.value});
    if (claim_.published) {
      readings.push_back(
          published_beside(metric_)->read(context_of(group_.sides.front().front(), published_)));
      if (!readings.back().number)
        return add_verdict(Verdict::kUnchecked, "no figure is published");
    }
    if (claim_.compare == Comparison::kFigure) {
      add({{*readings[0].number},
           *readings[0].number,
           interval_if(whole(readings[0]), !lacks_interval(readings[0]))},
          text_of(readings[0]));
    } else if (claim_.ordered) {
      for (std::size_t i = 1; i < readings.size(); ++i) compare(readings[i], readings[i - 1]);
    } else {
      compare(readings[0], readings[1]);
    }
  }

  void compare(const Reading& left, const Reading& right) {
    const bool ratio = claim_.compare == Comparison::kRatio;
    const Interval l = whole(left), r = whole(right);
    const double value = ratio ? *left.number / *right.number : *left.number - *right.number;
    const Interval interval =
        ratio ? Interval{l.low / r.high, l.high / r.low} : Interval{l.low - r.high, l.high - r.low};
    const std::string text =
        fmt::format("{} {} {}", text_of(left), ratio ? "/" : "-", text_of(right));
    if ((ratio && (r.low <= 0 || l.low < 0)) || std::isnan(value)) {
      return add_verdict(Verdict::kUnchecked,
                         fmt::format("{} has no {}", text, name_of(claim_.compare)));
    }
    add({{*left.number, *right.number},
         value,
         interval_if(interval, !lacks_interval(left) && !lacks_interval(right))},
        fmt::format("{} = {:.4g}", text, value));
  }

  void add(const Comparand& found, std::string text) {
    if (!found.interval) {
      text += fmt::format(", repeated fewer than {} times", kLeastRepetitions);
    } else if (found.interval->low != found.interval->high &&
               claim_.compare != Comparison::kFigure) {
      text += fmt::format(" [{:.4g}, {:.4g}]", found.interval->low, found.interval->high);
    }
    result_.compared.push_back(found);
    add_verdict(found.interval ? judge(claim_, *found.interval) : Verdict::kUndecided, text);
  }

  /// The worst of several counts: what cannot be checked, then what does not hold, then what is
  /// undecided.
  void add_verdict(Verdict verdict, const std::string& text) {
    static constexpr std::array kWorstLast{Verdict::kHolds, Verdict::kUndecided,
                                           Verdict::kDoesNotHold, Verdict::kUnchecked};
    const auto rank = [](Verdict v) {
      return std::ranges::find(kWorstLast, v) - kWorstLast.begin();
    };
    if (result_.reason.empty() || rank(verdict) > rank(result_.verdict)) result_.verdict = verdict;
    result_.reason += (result_.reason.empty() ? "" : "; ") + text;
  }

  void judge_curves() {
    std::vector<std::vector<RatePoint>> curves;
    const Metric& over = *find_metric(claim_.over);
    for (const auto& side : group_.sides) {
      std::vector<RatePoint> points;
      for (const TableLine& line : side) {
        const LineContext context = context_of(line, {});
        const Reading rate = over.read(context), error = metric_.read(context);
        if (!rate.number || !error.number)
          return add_verdict(Verdict::kUnchecked,
                             why_missing(line, rate.number ? claim_.metric : claim_.over));
        points.push_back({*rate.number, *error.number});
      }
      curves.push_back(std::move(points));
    }
    const auto found = bd_psnr(curves[1], curves[0]);
    if (!found) return add_verdict(Verdict::kUnchecked, found.error().message);
    add({{}, found->db, Interval{found->db, found->db}},
        fmt::format("{:+.2f} dB over {:.3f} .. {:.3f}", found->db, found->least_bits,
                    found->largest_bits));
  }

  const ClaimSpec& claim_;
  const Group& group_;
  const std::optional<PublishedTable>& published_;
  const Metric& metric_;
  GroupVerdict result_;
};

Verdict summarise(const ClaimVerdict& all) {
  const std::size_t holds = all.count(Verdict::kHolds), fails = all.count(Verdict::kDoesNotHold);
  const std::size_t undecided = all.count(Verdict::kUndecided), checked = holds + fails + undecided;
  if (checked == 0) return Verdict::kUnchecked;
  const auto enough = [&](std::size_t count) {
    switch (all.claim->quorum) {
      case Quorum::kAll:
        return count == checked;
      case Quorum::kMost:
        return 2 * count > checked;
      case Quorum::kSome:
        return count > 0;
    }
    return false;
  };
  if (enough(holds)) return Verdict::kHolds;
  return enough(holds + undecided) ? Verdict::kUndecided : Verdict::kDoesNotHold;
}

std::size_t fitted_groups(const ClaimVerdict& verdict) {
  return static_cast<std::size_t>(std::ranges::count(verdict.groups, true, &GroupVerdict::fitted));
}

std::string counts_text(const ClaimVerdict& verdict) {
  std::string text;
  for (const Verdict kind : kVerdicts) {
    if (const std::size_t count = verdict.count(kind); count > 0)
      text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", name_of(kind), count);
  }
  if (const std::size_t count = fitted_groups(verdict); count > 0)
    text += fmt::format("{}fitted: {}", text.empty() ? "" : ", ", count);
  return text;
}

/// Least and largest figure, difference or ratio of all groups.
std::string range_of(const ClaimVerdict& verdict) {
  std::vector<double> values;
  for (const GroupVerdict& group : verdict.groups) {
    if (group.fitted) continue;
    for (const Comparand& compared : group.compared) values.push_back(compared.value);
  }
  if (values.empty()) return "";
  const auto [least, largest] = std::ranges::minmax(values);
  return least == largest ? fmt::format("{:.4g}", least)
                          : fmt::format("{:.4g} .. {:.4g}", least, largest);
}

std::string counts_and_range(const ClaimVerdict& verdict) {
  const std::string range = range_of(verdict);
  return counts_text(verdict) + (range.empty() ? "" : "; " + range);
}

std::string verdict_text(const GroupVerdict& group) {
  return std::string(name_of(group.verdict)) + (group.fitted ? ", fitted" : "");
}

std::string quorum_text(Quorum quorum) {
  return quorum == Quorum::kMost   ? " in most groups"
         : quorum == Quorum::kSome ? " in some group"
                                   : "";
}

Row number_or_null(double value) { return std::isfinite(value) ? Row(value) : Row(nullptr); }

Row describe(const Comparand& compared) {
  Row row;
  row["sides"] = Row::array();
  for (const auto& side : compared.sides)
    row["sides"].push_back(side ? number_or_null(*side) : Row(nullptr));
  row["value"] = number_or_null(compared.value);
  if (compared.interval)
    row["interval"] = {number_or_null(compared.interval->low),
                       number_or_null(compared.interval->high)};
  return row;
}

}  // namespace

std::size_t ClaimVerdict::count(Verdict wanted) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      groups, [wanted](const auto& group) { return !group.fitted && group.verdict == wanted; }));
}

void check_claims(const Config& config) {
  for (const ClaimSpec& claim : config.claims) {
    if (!claim.not_testable.empty()) continue;
    const auto groups = collect_groups(claim, config, {});
    if (groups.empty()) {
      throw volumes::InputError(fmt::format(
          "{}: expected cells of the stage{} that match, found none", claim.sides.front().place,
          claim.renders ? " render" : "s encode, decode or random-access"));
    }
    for (const Group& group : groups) {
      for (std::size_t side = 0; side < claim.sides.size(); ++side) {
        const std::size_t lines = group.sides[side].size();
        if (lines == 0)
          throw volumes::InputError(fmt::format("{}: expected cells that match{}, found none",
                                                claim.sides[side].place, describe(group.labels)));
        if (lines > 1 && claim.over.empty()) {
          throw volumes::InputError(fmt::format(
              "{}: expected cells that agree in codec, parameters and threads{}, found {} that do "
              "not, '{}' and '{}'",
              claim.sides[side].place, describe(group.labels), lines,
              group.sides[side][0].cell->line_key(), group.sides[side][1].cell->line_key()));
        }
      }
    }
  }
}

std::vector<ClaimVerdict> judge_claims(const Config& config, const std::vector<Result>& rows) {
  const auto latest = latest_by(rows, &Result::key);
  std::vector<ClaimVerdict> verdicts;
  for (const ClaimSpec& claim : config.claims) {
    if (!claim.not_testable.empty()) {
      verdicts.push_back({&claim, {{.labels = {}, .reason = claim.not_testable}}});
      continue;
    }
    std::optional<PublishedTable> published;
    if (const auto& place = claim.published)
      published = load_published(place->file, place->table, place->scaled);
    ClaimVerdict verdict{&claim, {}};
    for (const Group& group : collect_groups(claim, config, latest))
      verdict.groups.push_back(GroupJudge(claim, group, published).judge_group());
    verdict.verdict = summarise(verdict);
    verdicts.push_back(std::move(verdict));
  }
  return verdicts;
}

Table claims_table(const Config& config, const std::vector<ClaimVerdict>& verdicts) {
  Table table;
  table.name = "claims";
  table.title = "Claims" + (config.title.empty() ? "" : ": " + config.title);
  for (const char* column : {"claim", "verdict", "figures"}) table.add_label(column);
  for (const ClaimVerdict& verdict : verdicts) {
    const ClaimSpec& claim = *verdict.claim;
    table.add_line(
        {claim.name, std::string(name_of(verdict.verdict)),
         verdict.groups.size() == 1 ? verdict.groups.front().reason : counts_and_range(verdict)});
    table.notes.push_back(
        Note()
            .term(claim.name)
            .own(": \"")
            .given(claim.says)
            .own("\" (")
            .given(claim.source)
            .own(claim.not_testable.empty()
                     ? fmt::format("). Checked: {}, {}{}.", claim.metric, claim.describe_bounds(),
                                   quorum_text(claim.quorum))
                     : ")."));
  }
  return table;
}

Table claims_summary(const std::vector<ClaimVerdict>& verdicts) {
  Table table;
  table.name = "claims";
  table.title = "Claims";
  for (const char* column : {"claim", "verdict", "groups", "least .. largest"})
    table.add_label(column);
  for (const ClaimVerdict& verdict : verdicts) {
    const ClaimSpec& claim = *verdict.claim;
    const bool testable = claim.not_testable.empty();
    table.add_line(
        {fmt::format("{} ({})", claim.says, claim.source), std::string(name_of(verdict.verdict)),
         testable
             ? fmt::format("{} / {} / {}", verdict.count(Verdict::kHolds),
                           verdict.count(Verdict::kDoesNotHold), verdict.count(Verdict::kUndecided))
             : "",
         testable ? range_of(verdict) : claim.not_testable});
  }
  return table;
}

Table groups_table(const std::vector<ClaimVerdict>& verdicts, bool with_cells) {
  Table table;
  table.name = "groups";
  table.title = "Each group of these claims";
  for (const char* column : {"claim", "group", "verdict", "figures"}) table.add_label(column);
  if (with_cells) table.add_label("cells");
  for (const ClaimVerdict& verdict : verdicts) {
    for (const GroupVerdict& group : verdict.groups) {
      std::vector<std::string> line{verdict.claim->name,
                                    fmt::format("{}", fmt::join(group.labels, " ")),
                                    verdict_text(group), group.reason};
      if (with_cells) line.push_back(fmt::format("{}", fmt::join(group.cells, " ")));
      table.add_line(std::move(line));
    }
  }
  return table;
}

std::vector<Row> claims_rows(const std::vector<ClaimVerdict>& verdicts) {
  std::vector<Row> rows;
  for (const ClaimVerdict& verdict : verdicts) {
    const ClaimSpec& claim = *verdict.claim;
    for (const GroupVerdict& group : verdict.groups) {
      Row row{{"claim", claim.name},
              {"says", claim.says},
              {"source", claim.source},
              {"claim_verdict", name_of(verdict.verdict)}};
      row["group"] = Row::object();
      for (std::size_t i = 0; i < claim.each.size(); ++i)
        row["group"][claim.each[i]] = group.labels[i];
      row["verdict"] = name_of(group.verdict);
      row["reason"] = group.reason;
      row["fitted"] = group.fitted;
      row["cells"] = group.cells;
      row["metric"] = claim.metric;
      row["compare"] = name_of(claim.compare);
      row["at_least"] = number_or_null(claim.at_least);
      row["at_most"] = number_or_null(claim.at_most);
      row["tolerance"] = claim.tolerance;
      row["compared"] = Row::array();
      for (const Comparand& compared : group.compared)
        row["compared"].push_back(describe(compared));
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace cvr::experiments
