// What a row says that can be compared with another row of the same cell.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/results/rows.hpp"
#include "volumes/enum_names.hpp"

namespace cvr::experiments {

enum class QuantityKind : std::uint8_t {
  kExact,  ///< sizes, counts of wrong voxels and pixels, checksums, errors: the same wherever the same code runs
  kCounted,  ///< work and memory: nearly the same from run to run
  kTime,     ///< samples
};
inline constexpr auto kQuantityKindNames =
    volumes::enum_names<QuantityKind>({{QuantityKind::kExact, "exact"},
                                       {QuantityKind::kCounted, "counted"},
                                       {QuantityKind::kTime, "time"}});
constexpr std::string_view name_of(QuantityKind kind) { return kQuantityKindNames.of(kind); }

struct Quantity {
  std::string name;  ///< for instance "size.bytes", "decode", "access uniform level 0", "frame"
  QuantityKind kind;
  std::string text = {};              ///< of exact figures that are no number
  std::optional<double> number = {};  ///< of exact and counted figures
  std::vector<double> samples =
      {};                 ///< of times: one per round, in the order of the rounds, above 0
  std::string unit = {};  ///< of times: "s", "ns", "ms"
  std::string_view noise_class = {};  ///< of times: whose noise floor counts, one of kNoiseClasses
};

inline constexpr std::array<std::string_view, 5> kNoiseClasses{"encode", "decode", "random-access",
                                                               "frame", "held frame"};

/// Of a row whose status is ok, in a fixed order; of another nothing.
std::vector<Quantity> quantities_of(const Result& row);

/// Largest relative difference that says nothing: 0 of what is exact but for errors (10^-9: sums in
/// another order).
double tolerance_of(const Quantity& quantity);

}  // namespace cvr::experiments
