#include "experiments/runner.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <random>
#include <thread>

#include "experiments/journal.hpp"
#include "experiments/provenance.hpp"
#include "experiments/row_building.hpp"
#include "experiments/worker_process.hpp"
#include "gpu/vulkan/device.hpp"

namespace cvr::experiments {

namespace {

namespace fs = std::filesystem;

constexpr double kGrace = 5;  // seconds for a worker to free its memory and end

double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// One program's part in a cell.
struct Side {
  std::size_t contender;
  std::unique_ptr<WorkerProcess> worker;
  Row parts;  ///< of the check
  Measured measured;
  double busy_seconds = 0;  ///< in rounds
  double check_seconds = 0;
  std::uint64_t peak_bytes = 0;  ///< of the rounds, as the worker tells; 0: it does not
};

/// A cell that is being measured.
struct Active {
  const PlannedCell* planned;
  std::vector<Side> sides;  ///< one a contender
};

std::vector<Sample> samples_of(const Row& round) {
  std::vector<Sample> samples;
  for (const Row& s : round) {
    samples.push_back({s.at(0).get<std::string>(), s.at(1).get<double>(), s.at(2).get<double>(),
                       s.at(3).get<std::uint64_t>()});
  }
  return samples;
}

class Runner {
 public:
  Runner(const Config& config, const RunOptions& options)
      : config_(config),
        options_(options),
        provenance_(describe_machine_and_build()),
        journal_((fs::path(options.contenders.front().out) / "journal.jsonl").string(), provenance_.dump(),
                 options.redo || options.contenders.size() > 1),
        cores_(std::max(1u, std::thread::hardware_concurrency())) {
    for (const Contender& contender : options.contenders) {
      outputs_.push_back({contender.out, std::make_unique<RowWriter>((fs::path(contender.out) / "rows.jsonl").string()),
                          (fs::path(contender.out) / "scratch").string(), provenance_});
      if (options.contenders.size() > 1) outputs_.back().provenance["revision"] = revision_of(contender.program);
    }
  }

  RunSummary run() {
    const auto rows = load_rows((fs::path(options_.contenders.front().out) / "rows.jsonl").string());
    const auto plan = plan_cells(config_, options_.filter, options_.places, rows, options_.redo);
    summary_.total = plan.size();
    for (const PlannedCell& planned : plan) {
      if (planned.decision == Decision::kRun) expected_seconds_ += planned.expected_seconds;
    }
    require_device(plan);
    for (const Output& output : outputs_) {
      fs::remove_all(output.scratch);
      fs::create_directories(output.scratch);
    }
    for (std::size_t first = 0; first < plan.size() && !interrupted();) {
      std::size_t last = first;
      while (last < plan.size() && plan[last].location == plan[first].location) ++last;
      run_dataset({plan.data() + first, last - first});
      first = last;
    }
    for (const Output& output : outputs_) fs::remove_all(output.scratch);
    summary_.interrupted = interrupted();
    if (!summary_.interrupted) journal_.remove();
    return summary_;
  }

 private:
  /// One clear end in place of a failed row a cell where nothing can draw. Throws gpu::DeviceError.
  void require_device(const std::vector<PlannedCell>& plan) const {
    const bool draws = std::ranges::any_of(plan, [](const PlannedCell& planned) {
      return planned.decision == Decision::kRun && planned.cell.stage == Stage::kRender;
    });
    if (draws) const gpu::Device there({.choice = config_.device});
  }

  bool interrupted() const { return options_.interrupted != nullptr && *options_.interrupted != 0; }

  void say(const std::string& text, bool cell_ended = false) const {
    if (options_.progress) options_.progress({ended_, summary_.total, text, cell_ended, seconds_left()});
  }

  double seconds_left() const {
    const double done = std::min(expected_done_, expected_seconds_);
    return done > 0 ? (now_seconds() - begin_) * (expected_seconds_ - done) / done : expected_seconds_;
  }

  /// The last contender's row ends the cell.
  void write(const PlannedCell& planned, std::size_t contender, const Row& row) {
    outputs_[contender].rows->append(row);
    if (contender + 1 < outputs_.size()) return;
    ++ended_;
    if (planned.decision == Decision::kRun) expected_done_ += planned.expected_seconds;
    const std::string status = row["status"].get<std::string>();
    ++summary_.by_status[status];
    std::string text = fmt::format("{}: {}", planned.cell.describe(), status);
    if (status != kOk) {
      text += fmt::format(" ({})", row["reason"].get<std::string>());
    } else if (row.contains("frames")) {
      text += fmt::format(", {:.4g} ms a frame, {} rounds", row["frames"]["mean_ms"].get<double>(),
                          row["time"]["rounds"].get<int>());
    } else if (row["time"].contains("seconds")) {
      text += fmt::format(", {:.4g} s, {} rounds", row["time"]["seconds"]["median"].get<double>(),
                          row["time"]["rounds"].get<int>());
    } else if (!row["access"].empty()) {
      text += fmt::format(", {:.4g} ns a voxel", row["access"][0]["ns_per_voxel"]["median"].get<double>());
    }
    say(text, true);
  }

  void end_without_measurement(const PlannedCell& planned, std::string_view status,
                               const std::string& reason) {
    for (std::size_t i = 0; i < outputs_.size(); ++i)
      write(planned, i, start_row(planned, copy_, outputs_[i].provenance, config_.hash, status, reason));
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
      copy_ = materialise(*to_run.front()->location, options_.places, cores_);
    } catch (const volumes::InputError& error) {
      for (const PlannedCell* planned : to_run) end_without_measurement(*planned, kDataMissing, error.what());
      return;
    }
    for (const Stage stage : kStages) {
      std::vector<const PlannedCell*> group;
      for (const PlannedCell* planned : to_run) {
        if (planned->cell.stage == stage) group.push_back(planned);
      }
      run_groups(group);
    }
    for (const Output& output : outputs_) {
      for (const auto& file : fs::directory_iterator(output.scratch)) fs::remove(file);
    }
  }

  /// Cuts what would not fit into memory together, in the order of the configuration.
  void run_groups(const std::vector<const PlannedCell*>& cells) {
    const std::uint64_t available = available_memory();
    std::vector<std::vector<const PlannedCell*>> groups;
    std::uint64_t used = 0;
    for (const PlannedCell* planned : cells) {
      if (groups.empty() || (available > 0 && used + planned->expected_memory > available)) {
        groups.emplace_back();
        used = 0;
      }
      groups.back().push_back(planned);
      used += planned->expected_memory * outputs_.size();
    }
    for (std::size_t i = 0; i < groups.size() && !interrupted(); ++i) {
      group_text_ = groups.size() == 1
                        ? fmt::format("{} cells", cells.size())
                        : fmt::format("{} cells, part {} of {}: the memory does not hold all {} at once",
                                      groups[i].size(), i + 1, groups.size(), cells.size());
      run_group(groups[i]);
    }
  }

  /// OUT/pictures/DATASET-CODEC-SCENE-ID, whatever characters the names have.
  static std::string place_of_pictures(const PlannedCell& planned, const std::string& out) {
    std::string name = fmt::format("{}-{}-{}-{}", planned.cell.dataset->name, planned.cell.codec,
                                   fs::path(planned.cell.render->scene).stem().string(), planned.id);
    std::ranges::replace_if(
        name, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '_' && c != '.'; }, '_');
    const fs::path folder = fs::path(out) / "pictures";
    fs::create_directories(folder);
    return fs::absolute(folder / name).string();
  }

  /// A contender's.
  struct Output {
    std::string out;
    std::unique_ptr<RowWriter> rows;
    std::string scratch;
    Row provenance;
  };

  WorkerSpec spec_of(const PlannedCell& planned, const Output& output) const {
    WorkerSpec spec;
    spec.location = *planned.location;
    spec.raw_path = copy_.path;
    spec.codec = planned.cell.codec;
    spec.parameters = planned.cell.parameters.canonical();
    spec.stage = planned.cell.stage;
    spec.threads = planned.cell.threads.count;
    spec.bytes_per_voxel = planned.cell.dataset->bytes_per_voxel;
    spec.memory_limit = static_cast<std::uint64_t>(config_.memory_limit_gib * (1 << 30));
    spec.scratch = output.scratch;
    spec.seed = config_.seed;
    spec.lods = config_.lods;
    spec.render = planned.cell.render;
    if (spec.render && spec.render->keep_pictures) spec.pictures = place_of_pictures(planned, output.out);
    if (config_.test_fault && fnmatch(config_.test_fault->codec.c_str(), spec.codec.c_str(), 0) == 0 &&
        fnmatch(config_.test_fault->stage.c_str(), std::string(name_of(spec.stage)).c_str(), 0) == 0) {
      spec.fault = config_.test_fault->fault;
    }
    return spec;
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

  /// False when a contender's check failed, and the cell has ended with it.
  bool check_all(Active& one) {
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      Side& side = one.sides.emplace_back(Side{i, std::make_unique<WorkerProcess>(options_.contenders[i].program), {}, {}});
      const double start = now_seconds();
      side.worker->send(to_json_line(spec_of(*one.planned, outputs_[i])));
      Row message;
      const auto outcome = side.worker->receive(config_.timeout_s, message);
      side.check_seconds = now_seconds() - start;
      if (outcome != WorkerProcess::Wait::kMessage || message.value("event", "") != "ready") {
        end_badly(one, side, outcome, message, "the check");
        return false;
      }
      side.parts = message["parts"];
    }
    for (const Row& round : journal_.rounds_of(one.planned->id)) one.sides.front().measured.add(samples_of(round));
    return true;
  }

  /// Fisher-Yates; std::shuffle's order differs between libraries.
  static void shuffle(std::vector<Active>& active, std::mt19937_64& order) {
    for (std::size_t i = active.size(); i > 1; --i) std::swap(active[i - 1], active[order() % i]);
  }

  /// A round of each side. False when the cell has ended and its rows are written.
  bool do_round(Active& one, std::mt19937_64& order) {
    say(fmt::format("{}: round {}", one.planned->cell.describe(), one.sides.front().measured.rounds + 1));
    const std::size_t first = one.sides.size() > 1 ? order() % one.sides.size() : 0;
    // Two processes each at home on a core of its own would meet what else these cores do: both take the round on the same one.
    if (one.sides.size() > 1 && one.planned->cell.threads.count == 1 && one.planned->cell.stage != Stage::kRender) {
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
    const double start = now_seconds();
    side.worker->send("round\n");
    Row message;
    const auto outcome = side.worker->receive(config_.timeout_s, message);
    if (outcome != WorkerProcess::Wait::kMessage || message.value("event", "") != "round") {
      end_badly(one, side, outcome, message, fmt::format("round {}", side.measured.rounds + 1));
      return false;
    }
    side.busy_seconds += now_seconds() - start;
    side.measured.add(samples_of(message["samples"]));
    side.peak_bytes = message.value("peak_bytes", std::uint64_t{0});
    if (one.sides.size() == 1) journal_.append(one.planned->id, message["samples"]);
    return true;
  }

  std::string reason_to_stop(const Side& side) const {
    const std::size_t rounds = side.measured.rounds;
    if (rounds >= config_.rounds && side.measured.relative_interval() <= config_.target_interval)
      return "target interval reached";
    if (rounds >= config_.max_rounds)
      return "largest number of rounds, the interval is wider than the target";
    if (side.busy_seconds >= config_.timeout_s) return fmt::format("time-out after {} rounds", rounds);
    return "";
  }

  void end_well(const PlannedCell& planned, Side& side, const std::string& stop) {
    side.worker->send("stop\n");
    const WorkerEnd end = side.worker->finish(kGrace);
    Row row = start_row(planned, copy_, outputs_[side.contender].provenance, config_.hash, kOk, "");
    for (const auto& [key, value] : side.parts.items()) row[key] = value;
    add_times(planned, side.measured, stop, row);
    const std::uint64_t input = copy_.path.empty() ? 0 : planned.location->info.bytes();
    const std::uint64_t peak = side.peak_bytes > 0 ? side.peak_bytes : end.peak_bytes;
    row["memory"]["peak_bytes"] = peak;
    row["memory"]["peak_over_input"] = peak > input ? peak - input : 0;
    row["interleave_group"] = group_text_;
    row["elapsed_seconds"] = side.check_seconds + side.busy_seconds;
    write(planned, side.contender, row);
  }

  /// A row a contender for a cell that did not come to its end, unless the run was interrupted instead.
  void end_badly(const Active& one, Side& side, WorkerProcess::Wait outcome, const Row& message, const std::string& when) {
    if (outcome == WorkerProcess::Wait::kInterrupted || interrupted()) return;
    const bool hangs = outcome == WorkerProcess::Wait::kTimeout;
    const WorkerEnd end = side.worker->finish(hangs ? 0 : kGrace);
    std::string status(kFailed), reason;
    if (hangs) {
      status = kTimeout;
      reason = fmt::format("{} took longer than {} s", when, config_.timeout_s);
    } else if (outcome == WorkerProcess::Wait::kMessage) {
      if (message.value("environment", false)) ++summary_.environment_failures;
      status = message.value("status", std::string(kFailed));
      reason = message.value("reason", "an answer that is none");
    } else if (end.signal == SIGKILL && !side.worker->killed()) {
      status = kOutOfMemory;
      reason = fmt::format("killed by the system in {}, as it does when memory runs out", when);
    } else {
      const std::string how = end.signal != 0
                                  ? fmt::format("signal {} ({})", end.signal, strsignal(end.signal))
                                  : fmt::format("exit code {}", end.exit_code);
      reason = fmt::format("crashed in {}: {}{}{}", when, how, end.complaints.empty() ? "" : ": ", end.complaints);
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      const bool own = i == side.contender;
      write(*one.planned, i,
            start_row(*one.planned, copy_, outputs_[i].provenance, config_.hash, own ? status : std::string(kFailed),
                      own ? reason : fmt::format("not measured: the other program's cell has ended: {}", reason)));
    }
  }

  /// What `PROGRAM --version` says in brackets.
  static std::string revision_of(const std::string& program) {
    const std::string line = first_line_of(fs::canonical(program).string(), "--version");
    const std::size_t from = line.find('('), to = line.find(')');
    return from == std::string::npos || to == std::string::npos ? line : line.substr(from + 1, to - from - 1);
  }

  const Config& config_;
  const RunOptions& options_;
  Row provenance_;
  std::vector<Output> outputs_;  ///< one a contender
  Journal journal_;
  unsigned cores_;
  RawCopy copy_;
  std::string group_text_;
  RunSummary summary_;
  std::size_t ended_ = 0;
  double begin_ = now_seconds(), expected_seconds_ = 0, expected_done_ = 0;
};

}  // namespace

RunSummary run_config(const Config& config, const RunOptions& options) {
  for (const Contender& contender : options.contenders) fs::create_directories(contender.out);
  return Runner(config, options).run();
}

}  // namespace cvr::experiments
