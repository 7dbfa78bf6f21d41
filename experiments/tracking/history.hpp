// Figures over commits: what was measured is kept, a series a cell, quantity and machine, and steps
// are found in it.
//
// The store is a folder with one file a machine, MACHINE.jsonl, a line a figure:
//   {"time": TIME, "revision": TEXT, "key": KEY, "codec": ID, "version": N, "quantity": NAME,
//   "kind": exact|counted|time, "unit": TEXT,
//    "class": NAME, "value": NUMBER|TEXT, "interval": [LOW, HIGH], "n": N}
#pragma once

#include <string>
#include <vector>

#include "experiments/tracking/noise_floor.hpp"
#include "experiments/tracking/quantities.hpp"
#include "experiments/tracking/steps.hpp"

namespace cvr::experiments {

struct Recorded {
  std::size_t figures = 0, rows = 0;
};
/// Appends the figures of the last row of each cell that is ok; those of a revision, time and key
/// that are there already are left out. Throws InputError and std::system_error.
Recorded record_history(const std::string& store, const std::vector<Result>& rows);

/// A change in a series: of times and counts by the fit, of exact figures each.
struct HistoryStep {
  std::string key, codec, quantity;
  QuantityKind kind;
  std::string machine;
  std::string revision, previous;  ///< of the first figure at the new level, and of the one before
  std::string time;
  std::string before, after;  ///< with the unit
  double ratio = 1;           ///< after / before; 1 of texts
  bool worse = false;         ///< slower, larger, more errors; of a text that changes: true
  bool last = false;          ///< nothing has changed since
};

struct History {
  std::size_t series = 0, figures = 0;
  std::vector<HistoryStep> steps;  ///< by time
};
/// `machine`: one fingerprint, or empty for all. Lines that cannot be read are an InputError
/// (FILE:LINE).
History read_history(const std::string& store, const std::string& machine,
                     const std::string& noise_path);

}  // namespace cvr::experiments
