// compare, ab, aa, baseline, history, export
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/cli/run_choices.hpp"
#include "experiments/results/provenance.hpp"
#include "experiments/run/run_folder.hpp"
#include "experiments/tracking/baseline.hpp"
#include "experiments/tracking/export.hpp"
#include "experiments/tracking/history.hpp"
#include "experiments/tracking/noise_measurement.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace {

namespace fs = std::filesystem;

struct TrackingChoices {
  RunChoices run;
  std::string base, fresh, noise, format = "md", fail_on = "slower";
  std::string store, machine, baseline, since;
  std::vector<std::string> results;
  std::uint64_t repeats = 2;
  bool explain = false, all_machines = false;
};

/// The floors that the rows' machine has.
NoiseFloors floors_for(const std::string& noise, const std::vector<Result>& rows,
                       Arrangement arrangement) {
  return rows.empty() ? NoiseFloors()
                      : load_floors(noise, rows.front().provenance.machine, arrangement);
}

int show_comparison(const TrackingChoices& c, const std::vector<Result>& base,
                    const std::vector<Result>& fresh, Arrangement arrangement) {
  const CompareReport report = compare_rows(
      base, fresh,
      {floors_for(c.noise, base, arrangement), arrangement == Arrangement::kInterleaved});
  if (c.format == "jsonl") {
    for (const Row& row : compare_to_rows(report)) fmt::print("{}\n", row.dump());
  } else {
    fmt::print("{}", describe(report, c.explain));
  }
  if (report.measured == 0 && !(report.differs() && c.fail_on != "never"))
    return end_with_nothing(kExitCheckFailed, "nothing was compared: no cell is ok in both, of " +
                                                  std::to_string(base.size()) + " and " +
                                                  std::to_string(fresh.size()) + " rows");
  const bool fails =
      c.fail_on != "never" && (report.differs() || (c.fail_on == "slower" && report.slower()));
  return fails ? kExitCheckFailed : kExitOk;
}

int compare(const TrackingChoices& c) {
  return show_comparison(c, rows_in(c.base), rows_in(c.fresh), Arrangement::kApart);
}

/// The rows of two programs, and how it went.
struct Contest {
  std::vector<Result> a, b;
  int exit_code = kExitOk;  ///< of the cells alone
};

/// Two programs round by round, into OUT/a and OUT/b.
Contest contest(const TrackingChoices& c, const Config& config, const std::string& out,
                const std::string& a, const std::string& b) {
  const std::vector<Contender> contenders{{a, (fs::path(out) / "a").string()},
                                          {b, (fs::path(out) / "b").string()}};
  const RunSummary summary = measure(config, c.run, contenders, true,
                                     fmt::format("{} keeps the cells that have ended", out));
  const bool none = !summary.by_status.contains(std::string(kOk));
  return {rows_in(contenders[0].out), rows_in(contenders[1].out),
          none ? exit_code_of(summary, (fs::path(contenders[1].out) / "rows.jsonl").string())
               : kExitOk};
}

int ab(const TrackingChoices& c) {
  const std::string out = c.run.out.empty() ? "results/local/ab" : c.run.out;
  for (const std::string& program : {c.base, c.fresh}) {
    if (!fs::is_regular_file(program))
      throw volumes::InputError(
          fmt::format("{}: expected a program cvrbench, found no file", program));
  }
  const Config config = load(c.run, c.run.configs.front());
  const auto lock = RunLock::take(out);
  const auto rows = contest(c, config, out, fs::absolute(c.base), fs::absolute(c.fresh));
  end_progress();
  if (rows.exit_code != kExitOk) return rows.exit_code;
  return show_comparison(c, rows.a, rows.b, Arrangement::kInterleaved);
}

void print_floors(std::string_view arrangement, const Row& floors) {
  for (const auto& [noise_class, entry] : floors.items()) {
    fmt::print("| {} | {} | {:.1f} % | {:.1f} % | {:.1f} % | {} |\n", arrangement, noise_class,
               100 * entry["floor"].get<double>(), 100 * entry["median"].get<double>(),
               100 * entry["largest"].get<double>(), entry["cells"].get<int>());
  }
}

int aa(const TrackingChoices& c, const Environment& environment) {
  const std::string out = c.run.out.empty() ? "results/local/aa" : c.run.out;
  const Config config = load(c.run, c.run.configs.front());
  const auto lock = RunLock::take(out);  // of all repeats
  std::vector<Repeat> together, apart;
  for (std::uint64_t i = 0; i < c.repeats; ++i) {
    Contest one = contest(c, config, (fs::path(out) / std::to_string(i)).string(),
                          environment.program, environment.program);
    if (one.exit_code != kExitOk) return one.exit_code;
    together.emplace_back(std::move(one.a), std::move(one.b));
    if (i > 0) {
      apart.emplace_back(together[i - 1].first, together[i].first);
      apart.emplace_back(together[i - 1].second, together[i].second);
    }
  }
  end_progress();
  const Row interleaved = measure_floors(together, true), separate = measure_floors(apart, false);
  if (interleaved.empty())
    return end_with_nothing(
        kExitCheckFailed,
        fmt::format("{}: no time was compared, so there are no floors to store", config.path));
  const Provenance provenance = describe_machine_and_build();
  const InterruptWatch watch;
  store_floors(c.noise, provenance, config.path, Arrangement::kInterleaved, interleaved);
  store_floors(c.noise, provenance, config.path, Arrangement::kApart, separate);
  fmt::print(
      "| runs | kind of time | floor | median ratio off by | largest | comparisons "
      "|\n|---|---|---:|---:|---:|---:|\n");
  print_floors("apart", separate);
  print_floors("interleaved", interleaved);
  std::size_t wrong = 0, compared = 0;
  for (const auto& [repeats, arrangement] :
       {std::pair{&together, Arrangement::kInterleaved}, {&apart, Arrangement::kApart}}) {
    for (const Repeat& repeat : *repeats) {
      const CompareReport report = compare_rows(repeat.first, repeat.second,
                                                {floors_for(c.noise, repeat.first, arrangement),
                                                 arrangement == Arrangement::kInterleaved});
      wrong += report.count(Outcome::kFaster) + report.count(Outcome::kSlower);
      for (const ComparedQuantity& one : report.comparisons)
        compared += one.base.kind == QuantityKind::kTime;
    }
  }
  fmt::print(
      "\n{} of {} comparisons of the build with itself are called faster or slower. Floors: {}\n",
      wrong, compared, c.noise);
  return kExitOk;
}

int check_or_update_baseline(const TrackingChoices& c, const Environment& environment, bool check) {
  int exit_code = kExitOk;
  for (const std::string& path : c.run.configs) {
    const Config config = load(c.run, path);
    const std::string file = baseline_path(c.baseline, config);
    const std::string out =
        c.run.out.empty() ? (fs::path("results/local/baseline") / fs::path(path).stem()).string()
                          : c.run.out;
    const auto lock = RunLock::take(out);  // until its rows have been read
    const RunSummary summary =
        measure(config, c.run, {{environment.program, out}}, true, "the baseline is as it was");
    end_progress();
    if (!summary.by_status.contains(std::string(kOk))) {
      exit_code =
          std::max(exit_code, exit_code_of(summary, (fs::path(out) / "rows.jsonl").string()));
      continue;
    }
    const Baseline found = baseline_of(config, rows_in(out));
    if (!check) {
      const InterruptWatch watch;
      store_baseline(file, found);
      fmt::print("{}: {} cells\n", file, found.cells.size());
      continue;
    }
    const BaselineReport report = compare_baselines(load_baseline(file), found);
    fmt::print("{}", describe(report, file));
    if (report.differs()) exit_code = std::max(exit_code, kExitCheckFailed);
    if (report.cells == 0)
      exit_code =
          end_with_nothing(kExitCheckFailed, fmt::format("{}: no cell of it was measured", file));
  }
  return exit_code;
}

int add_history(const TrackingChoices& c) {
  const InterruptWatch watch;
  bool any = false;
  for (const std::string& folder : c.results) {
    const std::vector<Result> rows = rows_in(folder);
    any = any || any_ok(rows);
    const Recorded recorded = record_history(c.store, rows);
    fmt::print("{}: {} figures of {} cells recorded in {}\n", volumes::printable(folder),
               recorded.figures, recorded.rows, volumes::printable(c.store));
  }
  return any ? kExitOk
             : end_with_nothing(kExitCheckFailed,
                                "nothing was recorded: no row of these folders is ok");
}

int show_history(const TrackingChoices& c) {
  std::string machine = c.machine;
  if (machine.empty() && !c.all_machines) machine = describe_machine_and_build().machine;
  const History history = read_history(c.store, machine, c.noise);
  bool worse = false;
  for (const HistoryStep& step : history.steps) {
    if (!c.since.empty() && step.time < c.since) continue;
    worse = worse || (step.worse && step.last);
    if (c.format == "jsonl") {
      fmt::print("{}\n", Row{{"time", step.time},
                             {"revision", step.revision},
                             {"previous", step.previous},
                             {"machine", step.machine},
                             {"key", step.key},
                             {"quantity", step.quantity},
                             {"before", step.before},
                             {"after", step.after},
                             {"ratio", step.ratio},
                             {"worse", step.worse},
                             {"last", step.last}}
                             .dump());
    } else {
      const auto shown = [](const std::string& text) { return volumes::printable(text); };
      fmt::print("{} {} (after {}): {} {}: {} -> {}{}{}\n", shown(step.time), shown(step.revision),
                 shown(step.previous), shown(step.key), shown(step.quantity), shown(step.before),
                 shown(step.after),
                 step.ratio == 1 ? "" : fmt::format(" ({:+.1f} %)", 100 * (step.ratio - 1)),
                 !step.worse ? ", better"
                 : step.last ? ", WORSE"
                             : ", worse, changed again since");
    }
  }
  if (c.format != "jsonl")
    fmt::print("{} series of {} figures, {} steps\n", history.series, history.figures,
               history.steps.size());
  if (history.figures == 0)
    return end_with_nothing(
        kExitCheckFailed,
        fmt::format("{}: no figures of {} are kept there; 'history add' records them", c.store,
                    machine.empty() ? "any machine" : "the machine " + machine));
  return worse ? kExitCheckFailed : kExitOk;
}

int export_rows(const TrackingChoices& c) {
  std::vector<Result> rows;
  for (const std::string& folder : c.results) {
    for (Result& row : rows_in(folder)) rows.push_back(std::move(row));
  }
  fmt::print("{}", c.format == "csv" ? to_csv(rows) : to_google_benchmark(rows).dump(1) + "\n");
  return any_ok(rows)
             ? kExitOk
             : end_with_nothing(kExitCheckFailed,
                                "nothing was exported but failures: no row of these folders is ok");
}

}  // namespace

void add_tracking_commands(CLI::App& app, const Environment& environment, int& exit_code) {
  auto c = std::make_shared<TrackingChoices>();
  c->run.data = environment.data;
  c->run.cache = environment.cache;
  c->noise = environment.share + "/noise.json";
  c->store = environment.share + "/history";
  const auto add_compare_options = [c](CLI::App& command) {
    command.add_flag("--explain", c->explain,
                     "every quantity with its figures and the reason of its verdict");
    command
        .add_option("--fail-on", c->fail_on,
                    "exact | slower | never: what makes the exit code 1; slower (default): exact "
                    "figures too")
        ->check(one_of({"exact", "slower", "never"}));
    command.add_option("--format", c->format, "md | jsonl")->check(one_of({"md", "jsonl"}));
    command.add_option("--noise", c->noise, "file of noise floors ('aa')");
  };
  const auto add_measuring = [c](CLI::App& command) {
    command.add_option("--out", c->run.out, "folder for rows");
    command.add_option("--device", c->run.device,
                       "that draws: index, or part of a name or type ('list devices')");
    add_config_options(command, c->run);
    add_data_options(command, c->run);
  };

  auto* comparing = app.add_subcommand(
      "compare", "Compares two runs: exact figures, counted work and times, each by its own rule");
  comparing->add_option("base", c->base, "folder with rows.jsonl")->required();
  comparing->add_option("new", c->fresh, "folder with rows.jsonl")->required();
  add_compare_options(*comparing);
  comparing->callback([c, &exit_code] { exit_code = compare(*c); });

  auto* versus = app.add_subcommand(
      "ab", "Measures two builds round by round side by side, and compares them");
  versus->add_option("a", c->base, "program of the base build")->required();
  versus->add_option("b", c->fresh, "program of the new build")->required();
  versus->add_option("configs", c->run.configs, "configuration file")->required()->expected(1);
  add_compare_options(*versus);
  add_measuring(*versus);
  versus->callback([c, &exit_code] { exit_code = ab(*c); });

  auto* itself = app.add_subcommand(
      "aa", "Measures this build against itself and stores the noise floors of this machine");
  itself->add_option("config", c->run.configs, "configuration file")->required()->expected(1);
  itself->add_option("--repeats", c->repeats, "runs one after the other, 2 by default")
      ->check(integer_in(2, 100));
  itself->add_option("--noise", c->noise, "file of noise floors");
  add_measuring(*itself);
  itself->callback([c, &environment, &exit_code] { exit_code = aa(*c, environment); });

  auto* baseline = app.add_subcommand(
      "baseline", "Checks exact figures against those under version control, or writes these anew");
  baseline->require_subcommand(1);
  for (const bool check : {true, false}) {
    auto* command = baseline->add_subcommand(
        check ? "check" : "update",
        check ? "1 where an exact figure differs; names codec, volume and section"
              : "measures and writes");
    command->add_option("configs", c->run.configs, "configuration files")->required();
    command->add_option(
        "--baseline", c->baseline,
        "folder of baselines (default: results/baseline beside the folder configs)");
    add_measuring(*command);
    command->callback([c, check, &environment, &exit_code] {
      exit_code = check_or_update_baseline(*c, environment, check);
    });
  }

  auto* history =
      app.add_subcommand("history", "Keeps figures over commits and finds steps in them");
  history->require_subcommand(1);
  auto* adding = history->add_subcommand("add", "Records the rows of runs");
  adding->add_option("results", c->results, "folders with rows.jsonl")->required();
  auto* showing = history->add_subcommand("steps",
                                          "Lists the steps and the commits that made them; 1 where "
                                          "the last step of a series is a worse one");
  showing->add_option("--machine", c->machine, "fingerprint (default: this machine)");
  showing->add_flag("--all-machines", c->all_machines, "series of all machines");
  showing
      ->add_option("--since", c->since, "only steps at this time (2026-01-31 or longer) or later")
      ->check(time_text());
  showing->add_option("--noise", c->noise, "file of noise floors ('aa')");
  showing->add_option("--format", c->format, "md | jsonl")->check(one_of({"md", "jsonl"}));
  for (auto* command : {adding, showing})
    command->add_option("--store", c->store, "folder of the history");
  auto* exporting = app.add_subcommand(
      "export", "Prints rows for other tools: the JSON of Google Benchmark, or CSV");
  exporting->add_option("results", c->results, "folders with rows.jsonl")->required();
  exporting->add_option("--format", c->format, "google-benchmark | csv")
      ->required()
      ->check(one_of({"google-benchmark", "csv"}));
  exporting->callback([c, &exit_code] { exit_code = export_rows(*c); });

  adding->callback([c, &exit_code] { exit_code = add_history(*c); });
  showing->callback([c, &exit_code] { exit_code = show_history(*c); });
}

}  // namespace cvr::experiments::cli
