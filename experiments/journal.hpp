// The samples of cells that have not come to their end, as JSON lines in OUT/journal.jsonl.
//
// Rounds of many cells are interleaved, so all of them end at about the same time. The journal keeps every round as it is made: a
// kill loses the round in progress, and --resume goes on with the rounds that are there (after checking the cell anew). Rounds of
// another machine or build do not count. The file goes when a run is complete.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/rows.hpp"

namespace cvr::experiments {

class Journal {
 public:
  /// `origin` names machine and build. `anew` throws older rounds away.
  Journal(const std::string& path, std::string origin, bool anew);
  /// The samples of each round of a cell so far, as the workers sent them.
  std::vector<Row> rounds_of(const std::string& cell) const;
  void append(const std::string& cell, const Row& samples);
  /// All cells have their rows.
  void remove();

 private:
  std::string path_, origin_;
  std::map<std::string, std::vector<Row>> rounds_;
  std::optional<RowWriter> writer_;
};

}  // namespace cvr::experiments
