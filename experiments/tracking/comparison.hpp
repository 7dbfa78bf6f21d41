// Two sets of rows against each other: exact figures, counted work and times, each by its own rule.
//
// Exact figures are compared always; one that differs is a difference. Counted work is more or less
// where it differs by more than its tolerance. Times are compared only between rows of the same
// cell and machine: a verdict starts at undecided and becomes
//   slower, faster   where the quartile ranges lie apart by more than the noise floor and a rank test gives p < kSignificance
//   same             where the 95 % interval of the ratio lies within the noise floor, or kSameMargin where that is more
// Series whose rounds were interleaved (of `ab`) are compared in pairs: the quartile range is that
// of the ratios, the test that of signs.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "experiments/tracking/noise_floor.hpp"
#include "experiments/tracking/quantities.hpp"
#include "experiments/tracking/rank_tests.hpp"
#include "volumes/enum_names.hpp"

namespace cvr::experiments {

inline constexpr double kSignificance = 0.002;
inline constexpr double kSameMargin = 0.05;

enum class Outcome : std::uint8_t {
  kSame,
  kFaster,
  kSlower,
  kUndecided,
  kDiffers,
  kMore,
  kLess,
  kNotCompared
};
inline constexpr std::size_t kOutcomes = 8;
inline constexpr auto kOutcomeNames =
    volumes::enum_names<Outcome>({{Outcome::kSame, "same"},
                                  {Outcome::kFaster, "faster"},
                                  {Outcome::kSlower, "slower"},
                                  {Outcome::kUndecided, "undecided"},
                                  {Outcome::kDiffers, "differs"},
                                  {Outcome::kMore, "more"},
                                  {Outcome::kLess, "less"},
                                  {Outcome::kNotCompared, "not compared"}});
constexpr std::string_view name_of(Outcome outcome) { return kOutcomeNames.of(outcome); }

/// One quantity of one cell.
struct ComparedQuantity {
  std::string key;  ///< of the rows
  std::string codec;
  std::string mode;  ///< the stage, or of images the access mode
  Quantity base, fresh;
  Outcome outcome = Outcome::kUndecided;
  double ratio = 1;          ///< new / base, of numbers and times
  double low = 0, high = 0;  ///< interval of the ratio, of times
  double p = 1;
  double gap = 0;    ///< how far the quartile ranges lie apart, of times
  double floor = 0;  ///< that the verdict was made by
  std::string reason;
};

/// The rule for times alone, base and fresh in the order of their rounds.
struct TimeVerdict {
  Outcome outcome;
  RatioEstimate estimate;
  double p;
  double gap;  ///< how far the quartile ranges lie apart, relative; 0 where they overlap
  std::string reason;
};
TimeVerdict judge_times(std::span<const double> base, std::span<const double> fresh, double floor,
                        bool paired);

struct CompareOptions {
  NoiseFloors floors;
  bool paired = false;
};

struct CompareReport {
  std::vector<ComparedQuantity> comparisons;  ///< in the order of the base rows
  std::vector<std::string> only_in_base,
      only_in_new;                   ///< keys of rows that are ok and have no partner
  std::vector<std::string> remarks;  ///< why times were not compared, what floor is assumed
  std::size_t measured = 0;          ///< cells that are ok in both
  std::size_t count(Outcome outcome) const;
  bool differs() const { return count(Outcome::kDiffers) > 0; }
  bool slower() const { return count(Outcome::kSlower) > 0; }
};

/// The last row of each cell counts. Rows with another status than ok are compared by their status
/// alone.
CompareReport compare_rows(const std::vector<Result>& base, const std::vector<Result>& fresh,
                           const CompareOptions& options);

/// One line per codec and mode: how many quantities came out how, and the geometric mean of the
/// ratios of times and of sizes.
struct CompareSummary {
  std::string codec, mode;
  std::size_t cells = 0;
  std::array<std::size_t, kOutcomes> counts{};
  double time_ratio = 0, size_ratio = 0;  ///< 0: none
};
std::vector<CompareSummary> summarise(const CompareReport& report);

/// Markdown: the summary, then what is not `same`; with `explain` every quantity with its figures
/// and reason.
std::string describe(const CompareReport& report, bool explain);
/// One object a quantity.
std::vector<Row> compare_to_rows(const CompareReport& report);

}  // namespace cvr::experiments
