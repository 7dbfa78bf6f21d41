// How far the quartile ranges of two measurements of one build lie apart on a machine, by kind of
// time: what a difference must exceed to say anything.
//
// Measured by `aa` and kept in a file, an object a machine (its fingerprint: provenance.hpp), later
// measurements in place of earlier:
//   {"MACHINE": {"cpu": TEXT, "time": TIME, "config": TEXT,
//                "apart": {"decode": {"floor": 0.08, "cells": 12, "largest": 0.08, "median": 0.01},
//                ..}, "interleaved": {..}}}
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "experiments/results/rows.hpp"
#include "volumes/enum_names.hpp"

namespace cvr::experiments {

/// Whether two series were measured one after the other, or round by round side by side.
enum class Arrangement : std::uint8_t { kApart, kInterleaved };
inline constexpr auto kArrangementNames = volumes::enum_names<Arrangement>(
    {{Arrangement::kApart, "apart"}, {Arrangement::kInterleaved, "interleaved"}});
constexpr std::string_view name_of(Arrangement arrangement) {
  return kArrangementNames.of(arrangement);
}

/// Assumed where nothing was measured.
inline constexpr double kAssumedFloor = 0.1;

class NoiseFloors {
 public:
  /// Relative, of a kind of time of kNoiseClasses; kAssumedFloor where none is known.
  double of(std::string_view noise_class) const;
  bool knows(std::string_view noise_class) const { return floors_.contains(noise_class); }
  void set(std::string_view noise_class, double floor) {
    floors_[std::string(noise_class)] = floor;
  }

 private:
  std::map<std::string, double, std::less<>> floors_;
};

/// What the file says of a machine; nothing is known where there is no file. Throws InputError for
/// a file that is none of ours.
NoiseFloors load_floors(const std::string& path, const std::string& machine,
                        Arrangement arrangement);
/// Puts `measured` (kind of time -> the object above) in the place of what the file says of the
/// machine and arrangement.
void store_floors(const std::string& path, const Provenance& provenance, const std::string& config,
                  Arrangement arrangement, const Row& measured);

}  // namespace cvr::experiments
