// The samples of cells that have not come to their end, as JSON lines in OUT/journal.jsonl.
//
// Rounds of many cells are interleaved, so all of them end at about the same time. The journal
// keeps every round as it is made: a kill loses the round in progress, and --resume goes on with
// the rounds that are there (after checking the cell anew). Rounds of another machine or build do
// not count. The file goes when a run is complete, unless it holds rounds of cells that are not the
// run's own.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "experiments/results/json_lines.hpp"
#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

struct Round {
  std::vector<Sample> samples;
  double seconds = 0;  ///< that the round took as its parent sees it
};

class Journal {
 public:
  /// `origin` names what rounds that may be mixed have in common: machine, build, what the
  /// configuration asks of a round. `anew` throws older rounds away. Only who holds the lock of the
  /// folder may make one. Throws OutputError, and InputError: "FILE:LINE: ..." for a line that is
  /// no round.
  Journal(const std::string& path, std::string origin, bool anew);
  /// The rounds of a cell so far.
  const std::vector<Round>& rounds_of(const std::string& cell) const;
  /// Throws OutputError.
  void append(const std::string& cell, const Round& round);
  /// Removes the file, unless it has rounds of a cell (of another configuration or filter) that is
  /// not among the ended ones, which have their rows. Identities of cells begin the names that
  /// append() was given, up to a space.
  void remove(const std::set<std::string>& ended);

 private:
  std::string path_, origin_;
  std::map<std::string, std::vector<Round>> rounds_;  ///< of this origin
  std::set<std::string> cells_;                       ///< of every origin
  std::optional<LineWriter> writer_;
};

}  // namespace cvr::experiments
