// Confirms or refutes the claims of a configuration from rows: one verdict a group, and one for the
// claim.
//
// Exact figures (sizes, errors, counts) are compared as they are. A time has the interval of its
// median; so have a difference and a ratio, from the ends of both sides' intervals. A claim holds
// where all of the interval lies within its bounds, does not hold where none of it does, and is
// undecided between; so is a time without an interval, having been repeated too seldom. What was
// not run, has failed, is unsupported or without data cannot be checked.
//
// A claim about several groups holds if it holds in all (most, some: claim_spec.hpp) of those that
// can be checked, and is undecided where the undecided groups would tip it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/analysis/reading.hpp"
#include "experiments/analysis/table.hpp"
#include "experiments/config/config.hpp"
#include "experiments/results/rows.hpp"
#include "volumes/enum_names.hpp"

namespace cvr::experiments {

enum class Verdict : std::uint8_t { kHolds, kDoesNotHold, kUndecided, kUnchecked };
inline constexpr auto kVerdictNames =
    volumes::enum_names<Verdict>({{Verdict::kHolds, "holds"},
                                  {Verdict::kDoesNotHold, "does not hold"},
                                  {Verdict::kUndecided, "undecided"},
                                  {Verdict::kUnchecked, "not testable here"}});
constexpr std::string_view name_of(Verdict verdict) { return kVerdictNames.of(verdict); }

/// A figure, difference or ratio, and the sides that it is made of.
struct Comparand {
  std::vector<std::optional<double>> sides;  ///< of curves none
  double value = 0;
  std::optional<Interval>
      interval;  ///< of exact figures the value itself; none of times that were repeated too seldom
};

struct GroupVerdict {
  std::vector<std::string> labels;  ///< values of the labels of `each`
  Verdict verdict = Verdict::kUnchecked;
  std::string reason;              ///< the figures, or why it cannot be checked
  bool fitted = false;             ///< proves nothing, and is not counted
  std::vector<std::string> cells;  ///< ids of the rows that the figures come from
  std::vector<Comparand>
      compared;  ///< one, of an order one for each pair; empty where it cannot be checked
};

struct ClaimVerdict {
  const ClaimSpec* claim;
  std::vector<GroupVerdict> groups;
  Verdict verdict = Verdict::kUnchecked;

  /// Of the groups that are not fitted.
  std::size_t count(Verdict verdict) const;
};

/// Throws InputError (FILE:LINE:COLUMN of the side) for a side without cells in a group, or with
/// several lines where it is no curve.
void check_claims(const Config& config);

/// The last row of a cell counts. Throws InputError for a file of published figures that cannot be
/// read. Points into `config`.
std::vector<ClaimVerdict> judge_claims(const Config& config, const std::vector<Result>& rows);

/// A line for each claim; of several groups how many have which verdict, and the range of their
/// figures.
Table claims_table(const Config& config, const std::vector<ClaimVerdict>& verdicts);
/// What a paper says, its verdict, how many groups hold / do not hold / are undecided, and the range
/// of their figures.
Table claims_summary(const std::vector<ClaimVerdict>& verdicts);
/// A line for each group of each claim; `with_cells`: and the ids of the rows.
Table groups_table(const std::vector<ClaimVerdict>& verdicts, bool with_cells = false);

/// One object for each group of each claim.
std::vector<Row> claims_rows(const std::vector<ClaimVerdict>& verdicts);

}  // namespace cvr::experiments
