// What a configuration says that a paper claims of its cells, as it is written. A side matches one
// line of a table in each group, or the lines of a curve; anything else is an error of the
// configuration. What cannot be tested is written down too, with its reason, so that no claim of a
// paper is passed over. docs/config.md lists the keys.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "experiments/config/table_spec.hpp"
#include "volumes/enum_names.hpp"

namespace cvr::experiments {

enum class Comparison : std::uint8_t { kFigure, kDifference, kRatio };
inline constexpr auto kComparisonNames =
    volumes::enum_names<Comparison>({{Comparison::kFigure, "figure"},
                                     {Comparison::kDifference, "difference"},
                                     {Comparison::kRatio, "ratio"}});
constexpr std::string_view name_of(Comparison comparison) {
  return kComparisonNames.of(comparison);
}

enum class Quorum : std::uint8_t { kAll, kMost, kSome };
inline constexpr auto kQuorumNames = volumes::enum_names<Quorum>(
    {{Quorum::kAll, "all"}, {Quorum::kMost, "most"}, {Quorum::kSome, "some"}});

struct ClaimSide {
  Conditions conditions;
  std::string place;  ///< FILE:LINE:COLUMN
};

struct ClaimSpec {
  std::string name, says, source, metric;
  std::vector<ClaimSide> sides;  ///< left, or left and right; of an order two or more
  bool ordered = false;
  std::optional<double> value;
  std::optional<PublishedPlace> published;
  Comparison compare = Comparison::kFigure;
  double at_least = -std::numeric_limits<double>::infinity(),
         at_most = std::numeric_limits<double>::infinity();
  double tolerance = 0;
  std::string over;  ///< empty: single figures
  std::vector<std::string> each;
  Conditions where;
  Quorum quorum = Quorum::kAll;
  Conditions fitted;         ///< groups whose stand-ins were made to meet the published figure
  std::string not_testable;  ///< why it cannot be tested with what is here; empty: it can
  bool renders = false;      ///< about cells of the stage render, as a metric or a label tells

  /// "left - right, at least 2, at most 4, tolerance 0.05".
  std::string describe_bounds() const;
};

/// A claim as it is read: its sides by their keys.
struct ClaimDraft {
  ClaimSpec claim;
  std::optional<ClaimSide> left, right;
};
/// `config_path`: what the path of published figures is relative to.
std::vector<Key<ClaimDraft>> claim_keys(const std::string& config_path, MetricNames metrics);
/// Throws InputError.
ClaimSpec read_claim(const YamlValue& value, const std::string& config_path, MetricNames metrics);

}  // namespace cvr::experiments
