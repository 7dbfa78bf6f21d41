#include "experiments/run/runner.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <xxhash.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>

#include "experiments/results/provenance.hpp"
#include "experiments/results/samples.hpp"
#include "experiments/run/cell_failure.hpp"
#include "experiments/run/journal.hpp"
#include "experiments/run/memory.hpp"
#include "experiments/run/raw_copies.hpp"
#include "experiments/run/row_building.hpp"
#include "experiments/run/run_folder.hpp"
#include "experiments/run/worker_process.hpp"
#include "experiments/run/worker_setup.hpp"
#include "experiments/stages/stage_kind.hpp"
#include "gpu/vulkan/device.hpp"

namespace cvr::experiments {

namespace {

double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// One program's part in a cell.
struct Side {
  std::size_t contender;
  std::unique_ptr<WorkerProcess> worker;
  WorkerLimits limits;
  Row parts;  ///< of the check
  Measured measured;
  double busy_seconds = 0;  ///< in rounds
  double check_seconds = 0;
  std::size_t processes = 1, rounds_of_process = 0;
  std::size_t left_out = 0;      ///< rounds of the journal beyond the largest number
  std::uint64_t peak_bytes = 0;  ///< of the rounds, as the worker tells; 0: it does not
};

/// A cell that is being measured.
struct Active {
  const PlannedCell* planned;
  std::vector<Side> sides;  ///< one a contender
};

class Runner {
 public:
  Runner(const Config& config, const RunOptions& options)
      : config_(config),
        options_(options),
        provenance_(describe_machine_and_build()),
        outputs_(make_outputs(options, provenance_)),
        journal_(outputs_.front().folder->file("journal.jsonl"), origin(),
                 options.redo || options.contenders.size() > 1),
        cores_(std::max(1u, std::thread::hardware_concurrency())) {}

  RunSummary run() {
    auto rows = load_rows(outputs_.front().folder->file("rows.jsonl"));
    for (const Result& row : rows) last_[row.cell] = {row.status, row.reason};
    rows.erase(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(
                                                std::min(options_.ignored_rows, rows.size())));
    const auto plan = plan_cells(config_, options_.filter, options_.places, rows, options_.redo);
    summary_.total = plan.size();
    for (const PlannedCell& planned : plan) {
      if (planned.decision == Decision::kRun) expected_seconds_ += planned.expected_seconds;
    }
    require_device(plan);
    for (std::size_t first = 0; first < plan.size() && !interrupted();) {
      std::size_t last = first;
      while (last < plan.size() && plan[last].location == plan[first].location) ++last;
      run_dataset({plan.data() + first, last - first});
      first = last;
    }
    summary_.interrupted = interrupted();
    if (!summary_.interrupted) journal_.remove(ended_cells(plan));
    return summary_;
  }

 private:
  /// A contender's.
  struct Output {
    std::unique_ptr<RunFolder> folder;
    Provenance provenance;
  };

  /// The locks of all folders are held before anything is changed in one of them.
  static std::vector<Output> make_outputs(const RunOptions& options, const Provenance& provenance) {
    std::vector<std::shared_ptr<const RunLock>> locks;
    for (const Contender& contender : options.contenders)
      locks.push_back(RunLock::take(contender.out));
    std::vector<Output> outputs;
    for (const Contender& contender : options.contenders) {
      outputs.push_back({std::make_unique<RunFolder>(contender.out), provenance});
      if (options.contenders.size() > 1)
        outputs.back().provenance.revision = revision_of(contender.program);
    }
    return outputs;
  }

  /// What rounds have in common that may be put together: machine and build, and what the
  /// configuration asks of a round.
  std::string origin() const {
    std::string text =
        fmt::format("{} seed {} lods {} memory {}", what_times_depend_on(provenance_), config_.seed,
                    fmt::join(config_.lods, ","), config_.memory_limit_gib);
    if (config_.rounds_per_process != Config{}.rounds_per_process)
      text += fmt::format(" a process for {}", config_.rounds_per_process);
    return fmt::format("{:016x}", XXH3_64bits(text.data(), text.size()));
  }

  /// A cell in the journal: rounds on other voxels are not its own.
  std::string in_journal(const PlannedCell& planned) const {
    return fmt::format("{} {}", planned.id,
                       copy_.content_hash.empty() ? "streamed" : copy_.content_hash);
  }

  /// Those of this run, and those of others with a row that is ok.
  std::set<std::string> ended_cells(const std::vector<PlannedCell>& plan) const {
    std::set<std::string> ended;
    for (const auto& [cell, outcome] : last_) {
      if (outcome.first == kOk) ended.insert(cell);
    }
    for (const PlannedCell& planned : plan) ended.insert(planned.id);
    return ended;
  }

  /// One clear end in place of a failed row per cell where nothing can draw. Throws gpu::DeviceError.
  void require_device(const std::vector<PlannedCell>& plan) const {
    const bool draws = std::ranges::any_of(plan, [](const PlannedCell& planned) {
      return planned.decision == Decision::kRun && planned.cell.stage->renders;
    });
    if (draws) const gpu::Device there({.choice = config_.device});
  }

  bool interrupted() const { return options_.interrupted != nullptr && *options_.interrupted != 0; }

  void say(const std::string& text, bool cell_ended = false) const {
    if (options_.progress)
      options_.progress({ended_, summary_.total, text, cell_ended, seconds_left()});
  }

  double seconds_left() const {
    const double done = std::min(expected_done_, expected_seconds_);
    return done > 0 ? (now_seconds() - begin_) * (expected_seconds_ - done) / done
                    : expected_seconds_;
  }

  /// The last contender's row ends the cell.
  void write(const PlannedCell& planned, std::size_t contender, const Result& result) {
    outputs_[contender].folder->append(result);
    if (contender + 1 == outputs_.size()) count(planned, result);
  }

  void count(const PlannedCell& planned, const Result& result) {
    ++ended_;
    if (planned.decision == Decision::kRun) expected_done_ += planned.expected_seconds;
    ++summary_.by_status[result.status];
    if (!result.is_ok()) summary_.last_reason = result.reason;
    say(describe_end(planned, result), true);
  }

  /// A row a contender, but none where the last row of the cell says the same.
  void end_without_measurement(const PlannedCell& planned, std::string_view status,
                               const std::string& reason) {
    const auto last = last_.find(planned.id);
    const bool known = !options_.redo && last != last_.end() &&
                       last->second == std::pair(std::string(status), reason);
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      const Result result =
          start_result(planned, copy_, outputs_[i].provenance, config_.hash, status, reason);
      if (!known) {
        write(planned, i, result);
      } else if (i + 1 == outputs_.size()) {
        count(planned, result);
      }
    }
    last_[planned.id] = {std::string(status), reason};
  }

  void run_dataset(std::span<const PlannedCell> cells) {
    copy_ = {};
    std::vector<const PlannedCell*> to_run;
    for (const PlannedCell& planned : cells) {
      switch (planned.decision) {
        case Decision::kRun:
          to_run.push_back(&planned);
          break;
        case Decision::kDone:
          ++ended_;
          ++summary_.skipped;
          break;
        case Decision::kUnsupported:
          end_without_measurement(planned, kUnsupported, planned.reason);
          break;
        case Decision::kDataMissing:
          end_without_measurement(planned, kDataMissing, planned.reason);
          break;
      }
    }
    if (to_run.empty()) return;
    say(fmt::format("{}: preparing {}", to_run.front()->cell.dataset->name,
                    to_string(to_run.front()->location->info.extent)));
    try {
      copy_ = materialise(*to_run.front()->location, options_.places, cores_,
                          [this] { return interrupted(); });
    } catch (const Interrupted&) {
      return;
    } catch (const volumes::InputError& error) {
      for (const PlannedCell* planned : to_run)
        end_without_measurement(*planned, kDataMissing, error.what());
      return;
    } catch (const volumes::OutputError& error) {
      summary_.environment_failures += to_run.size();
      for (const PlannedCell* planned : to_run)
        end_without_measurement(*planned, kFailed, error.what());
      return;
    }
    for (const StageKind* stage : all_stages()) {
      std::vector<const PlannedCell*> group;
      for (const PlannedCell* planned : to_run) {
        if (planned->cell.stage == &stage->traits()) group.push_back(planned);
      }
      run_groups(group);
    }
    for (const Output& output : outputs_) output.folder->empty_scratch();
  }

  /// Cuts what would not fit into memory together, in the order of the configuration.
  void run_groups(const std::vector<const PlannedCell*>& cells) {
    const std::uint64_t available = usable_memory();
    std::vector<std::vector<const PlannedCell*>> groups;
    std::uint64_t used = 0;
    for (const PlannedCell* planned : cells) {
      const std::uint64_t need = planned->expected_memory * outputs_.size();
      const bool full = available > 0 && used + need > available;
      if (groups.empty() || full || groups.back().size() >= config_.together) {
        groups.emplace_back();
        used = 0;
      }
      groups.back().push_back(planned);
      used += need;
    }
    for (std::size_t i = 0; i < groups.size() && !interrupted(); ++i) {
      group_text_ = groups.size() == 1
                        ? fmt::format("{} cells", cells.size())
                        : fmt::format("{} cells, part {} of {}: not all {} at once",
                                      groups[i].size(), i + 1, groups.size(), cells.size());
      run_group(groups[i]);
    }
  }

  void run_group(const std::vector<const PlannedCell*>& cells) {
    std::vector<Active> active;
    for (const PlannedCell* planned : cells) {
      if (interrupted()) return;
      say(fmt::format("{}: checking", planned->cell.describe()));
      Active one{planned, {}};
      if (check_all(one)) {
        active.push_back(std::move(one));
      } else if (interrupted()) {
        return;
      }
    }
    std::mt19937_64 order(config_.seed);
    while (!active.empty() && !interrupted()) {
      shuffle(active, order);
      for (std::size_t i = 0; i < active.size() && !interrupted();) {
        if (do_round(active[i], order)) {
          ++i;
        } else {
          active.erase(active.begin() + static_cast<std::ptrdiff_t>(i));
        }
      }
    }
  }

  /// An answer, or what came in its place.
  WorkerProcess::Wait ask(Side& side, const std::string& text, Row& message) const {
    side.worker->send(text);
    return side.worker->receive(config_.timeout_s, message, options_.interrupted);
  }

  /// False when a contender's check failed, and the cell has ended with it.
  bool check_all(Active& one) {
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      const WorkerSpec spec = make_spec(config_, *one.planned, copy_, *outputs_[i].folder);
      Side& side = one.sides.emplace_back(Side{i, nullptr, limits_of(config_, spec), {}, {}});
      const double start = now_seconds();
      if (!begin_worker(one, side, spec, "the check")) return false;
      side.check_seconds = now_seconds() - start;
    }
    recall_rounds(*one.planned, one.sides.front());
    return true;
  }

  /// A worker that is ready for rounds; the first one's parts are kept. False when it failed, and the
  /// cell has ended with it.
  bool begin_worker(Active& one, Side& side, const WorkerSpec& spec, const std::string& what) {
    side.worker =
        std::make_unique<WorkerProcess>(options_.contenders[side.contender].program, side.limits);
    side.rounds_of_process = 0;
    Row message;
    const auto outcome = ask(side, to_json_line(spec), message);
    if (outcome != WorkerProcess::Wait::kMessage || message["event"] != "ready" ||
        !message.contains("parts") || !message["parts"].is_object()) {
      end_badly(one, side, outcome, message, what);
      return false;
    }
    if (!spec.checked) side.parts = message["parts"];
    return true;
  }

  /// Another process in place of one that has made its rounds.
  bool replace_worker(Active& one, Side& side) {
    side.worker->send("stop\n");
    side.worker->finish(kGrace);
    WorkerSpec spec = make_spec(config_, *one.planned, copy_, *outputs_[side.contender].folder);
    spec.checked = true;
    if (!begin_worker(one, side, spec, fmt::format("the start of process {}", side.processes + 1)))
      return false;
    ++side.processes;
    return true;
  }

  /// Rounds of a run that was interrupted.
  void recall_rounds(const PlannedCell& planned, Side& side) {
    for (const Round& round : journal_.rounds_of(in_journal(planned))) {
      if (side.measured.rounds >= config_.max_rounds) {
        ++side.left_out;
        continue;
      }
      side.measured.add(round.samples);
      side.busy_seconds += round.seconds;
    }
  }

  /// Fisher-Yates; std::shuffle's order differs between libraries.
  static void shuffle(std::vector<Active>& active, std::mt19937_64& order) {
    for (std::size_t i = active.size(); i > 1; --i) std::swap(active[i - 1], active[order() % i]);
  }

  /// A round of each side. False when the cell has ended and its rows are written.
  bool do_round(Active& one, std::mt19937_64& order) {
    say(fmt::format("{}: round {}", one.planned->cell.describe(),
                    one.sides.front().measured.rounds + 1));
    const std::size_t first = one.sides.size() > 1 ? order() % one.sides.size() : 0;
    // Two processes each at home on a core of its own would meet what else these cores do: both
    // take the round on the same one.
    if (one.sides.size() > 1 &&
        kind_of(one.planned->cell).takes_turns_on_a_core(one.planned->cell)) {
      for (Side& side : one.sides) side.worker->move_to_core(one.sides.front().measured.rounds);
    }
    for (std::size_t i = 0; i < one.sides.size(); ++i) {
      if (!do_round_of(one, one.sides[(first + i) % one.sides.size()])) return false;
    }
    std::string stop;
    for (const Side& side : one.sides) {
      stop = reason_to_stop(side);
      if (stop.empty()) return true;
    }
    for (Side& side : one.sides) end_well(*one.planned, side, stop);
    return false;
  }

  bool do_round_of(Active& one, Side& side) {
    // A cell that has all its rounds from the journal makes one for the record of its memory, and
    // no time comes of it.
    const bool counts = one.sides.size() > 1 || reason_to_stop(side).empty();
    if (side.rounds_of_process >= config_.rounds_per_process && !replace_worker(one, side))
      return false;
    ++side.rounds_of_process;
    const double start = now_seconds();
    Row message;
    auto outcome = ask(side, "round\n", message);
    std::optional<std::vector<Sample>> samples;
    if (outcome == WorkerProcess::Wait::kMessage && message["event"] == "round" &&
        message.contains("samples"))
      samples = samples_from(message["samples"]);
    if (!samples) {
      end_badly(one, side, outcome, message, fmt::format("round {}", side.measured.rounds + 1));
      return false;
    }
    if (const auto peak = message.find("peak_bytes");
        peak != message.end() && peak->is_number_unsigned())
      side.peak_bytes = peak->get<std::uint64_t>();
    if (!counts) return true;
    const Round round{std::move(*samples), now_seconds() - start};
    side.busy_seconds += round.seconds;
    side.measured.add(round.samples);
    if (one.sides.size() == 1) journal_.append(in_journal(*one.planned), round);
    return true;
  }

  std::string reason_to_stop(const Side& side) const {
    const std::size_t rounds = side.measured.rounds;
    if (rounds >= config_.rounds && side.measured.relative_interval() <= config_.target_interval)
      return "target interval reached";
    if (rounds >= config_.max_rounds) {
      return fmt::format(
          "largest number of rounds, the interval is wider than the target{}",
          side.left_out == 0
              ? ""
              : fmt::format("; {} more of an interrupted run are left out", side.left_out));
    }
    if (side.busy_seconds >= config_.timeout_s)
      return fmt::format("time-out after {} rounds", rounds);
    return "";
  }

  void end_well(const PlannedCell& planned, Side& side, const std::string& stop) {
    side.worker->send("stop\n");
    const WorkerEnd end = side.worker->finish(kGrace);
    write(planned, side.contender, result_of(planned, side, stop, end));
  }

  Result result_of(const PlannedCell& planned, const Side& side, const std::string& stop,
                   const WorkerEnd& end) const {
    const Provenance& provenance = outputs_[side.contender].provenance;
    try {
      Result result = start_result(planned, copy_, provenance, config_.hash, kOk, "");
      const Row own = to_json(result);
      for (const auto& [key, value] : own.items()) {
        if (side.parts.contains(key))
          throw ShapeError(fmt::format("the part '{}' is none of a worker's", key));
      }
      static_cast<Parts&>(result) = from_json<Parts>(side.parts);
      add_times(planned, side.measured, stop, result);
      const std::uint64_t input = copy_.path.empty() ? 0 : planned.location->info.bytes();
      const std::uint64_t peak = side.peak_bytes > 0 ? side.peak_bytes : end.peak_bytes;
      if (!result.memory) result.memory.emplace();
      result.memory->peak_bytes = peak;
      result.memory->peak_over_input = peak > input ? peak - input : 0;
      result.interleave_group = group_text_;
      if (side.processes > 1) result.processes = side.processes;
      result.elapsed_seconds = side.check_seconds + side.busy_seconds;
      return result;
    } catch (const std::exception& error) {  // parts or series that are none
      return start_result(planned, copy_, provenance, config_.hash, kFailed,
                          fmt::format("gave answers that are none: {}", error.what()));
    }
  }

  /// A row a contender for a cell that did not come to its end, unless the run was interrupted
  /// instead.
  void end_badly(const Active& one, Side& side, WorkerProcess::Wait outcome, const Row& message,
                 const std::string& when) {
    if (outcome == WorkerProcess::Wait::kInterrupted || interrupted()) return;
    const CellFailure failure =
        end_and_explain(*side.worker, outcome, message, when, config_.timeout_s, side.limits);
    if (interrupted()) return;
    if (failure.environment) ++summary_.environment_failures;
    end_as(one, side, failure);
  }

  void end_as(const Active& one, const Side& side, const CellFailure& failure) {
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      const bool own = i == side.contender;
      write(*one.planned, i,
            start_result(*one.planned, copy_, outputs_[i].provenance, config_.hash,
                         own ? failure.status : std::string(kFailed),
                         own ? failure.reason
                             : fmt::format("not measured: the other program's cell has ended: {}",
                                           failure.reason)));
    }
  }

  const Config& config_;
  const RunOptions& options_;
  Provenance provenance_;
  std::vector<Output> outputs_;  ///< one a contender
  std::map<std::string, std::pair<std::string, std::string>>
      last_;  ///< status and reason of the last row of each cell
  Journal journal_;
  unsigned cores_;
  RawCopy copy_;
  std::string group_text_;
  RunSummary summary_;
  std::size_t ended_ = 0;
  double begin_ = now_seconds(), expected_seconds_ = 0, expected_done_ = 0;
};

}  // namespace

void RunSummary::add_ended(const RunSummary& other) {
  for (const auto& [status, count] : other.by_status) by_status[status] += count;
  environment_failures += other.environment_failures;
  if (!other.last_reason.empty()) last_reason = other.last_reason;
}

RunSummary run_config(const Config& config, const RunOptions& options) {
  return Runner(config, options).run();
}

}  // namespace cvr::experiments
