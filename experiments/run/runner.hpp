// Runs the cells of a configuration and appends their rows.
//
// Cells that share data set and stage form an interleave group: each has its worker process, all
// stay alive, and the parent asks one at a time for one round, in an order shuffled anew each
// round, so that slow drifts of the machine meet all alike. A cell is done when it has the least
// number of rounds and its median's 95 % interval is below the target, or the largest number of
// rounds, or its time-out; the row says which. Where the workers of a group would need more memory
// than there is, the group is cut.
//
// While a run goes on no other one can write to its folder (run_folder.hpp). However it ends, no
// worker outlives it. A cell's crash, hang, flood of output, or exhaustion of memory or disk is a
// row, never the end of the run; what ends a run is the user, or that rows and journal cannot be
// written.
//
// Two programs can run side by side (RunOptions::contenders): each cell then has a worker of each,
// which take every round one right after the other, the first to go drawn anew, single-threaded
// ones on the same core, another each round; they end together. Sample i of a row of one then pairs
// with sample i of the same row of the other.
#pragma once

#include <csignal>
#include <functional>
#include <string>
#include <vector>

#include "experiments/run/plan.hpp"

namespace cvr::experiments {

struct Progress {
  std::size_t done = 0, total = 0;
  std::string text;
  bool cell_ended = false;
  double seconds_left =
      0;  ///< by what the plan expects of the cells and how long those that have ended took; 0: unknown
};

/// A program that takes part, and the folder for its rows.jsonl and scratch files.
struct Contender {
  std::string program, out;
};

struct RunOptions {
  std::vector<Contender> contenders;  ///< one: this program; two: builds side by side
  Places places;
  Filter filter;
  bool redo =
      false;  ///< measure cells again that have rows, and forget the rounds of a run that was interrupted
  std::size_t ignored_rows =
      0;  ///< as many rows, the first of the file, do not say that a cell is done
  std::function<void(const Progress&)> progress;
  const volatile std::sig_atomic_t* interrupted = nullptr;
};

struct RunSummary {
  std::size_t total = 0, skipped = 0;
  std::map<std::string, std::size_t> by_status;
  std::size_t environment_failures =
      0;  ///< failed cells whose device was lost or had no memory left: nothing is said of the codec
  std::string last_reason;  ///< of the last cell that was not ok
  bool interrupted = false;

  /// Adds the cells of another one that have ended.
  void add_ended(const RunSummary& other);
};

/// Throws InputError, OutputError, EnvironmentError and std::system_error; failures of cells are
/// rows. A cell whose last row says already that it is unsupported or lacks its data gets no other
/// one.
RunSummary run_config(const Config& config, const RunOptions& options);

}  // namespace cvr::experiments
