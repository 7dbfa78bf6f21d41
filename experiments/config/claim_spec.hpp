// What a configuration says that a paper claims of its cells, as it is written:
//
//   claims:
//     - name: NAME      says: TEXT       the paper's words, shortened       source: TEXT      paper, section, figure
//       metric: METRIC                   any metric of tables that is a number
//       left: {LABEL: GLOB or [GLOBS]}   one line of a table in each group
//       right: {LABEL: GLOB or [GLOBS]}  what it is compared with; or
//       value: NUMBER                    or
//       published: {file: PATH, table: NAME}      the published figure of the same line and quantity; or none of them: the figure itself
//       order: [{LABEL: GLOB}, ..]       in place of left and right: lines by ascending metric
//       compare: difference | ratio      left - right or left / right; needed beside right, value, published and order
//       at_least: NUMBER   at_most: NUMBER     of the figure, difference or ratio; one of them or both, not beside order
//       tolerance: 0                     widens the bounds
//       over: METRIC                     the sides are curves of a PSNR over this metric, and their difference is the mean over the
//                                        logarithm of what both have (bd_psnr of
//                                        rate_distortion.hpp)
//       each: [LABEL, ..]                a group for each combination of values; default: one group
//       where: {LABEL: GLOB or [GLOBS]}  restricts all sides
//       holds_in: all | most | some      of the groups that can be checked, where the paper speaks of such a share; default: all
//
// A side matches one line in each group, or the lines of a curve; anything else is an error of the
// configuration.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "experiments/config/cells.hpp"
#include "experiments/config/metric_names.hpp"
#include "experiments/config/yaml_reader.hpp"

namespace cvr::experiments {

/// A table of a file of published figures.
struct PublishedPlace {
  std::string file, table;
};

enum class Comparison : std::uint8_t { kFigure, kDifference, kRatio };
/// "figure", "difference", "ratio".
std::string_view name_of(Comparison comparison);

enum class Quorum : std::uint8_t { kAll, kMost, kSome };

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
  bool renders = false;  ///< about cells of the stage render, as a metric or a label tells

  /// "left - right, at least 2, at most 4, tolerance 0.05".
  std::string describe_bounds() const;
};

/// `config_path`: what the path of published figures is relative to. Throws InputError.
ClaimSpec read_claim(const YamlValue& value, const std::string& config_path, MetricNames metrics);

}  // namespace cvr::experiments
