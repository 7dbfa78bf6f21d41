// run, plan, table, claims, and the hidden worker
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <set>

#include "experiments/analysis/claims.hpp"
#include "experiments/analysis/table_formats.hpp"
#include "experiments/analysis/tables.hpp"
#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/cli/run_choices.hpp"
#include "experiments/run/run_folder.hpp"
#include "experiments/run/worker.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace {

namespace fs = std::filesystem;

struct Choices : RunChoices {
  std::string format = "md", table;
};

void write_text(const fs::path& path, const std::string& text) {
  write_file(path.string(), std::as_bytes(std::span(text.data(), text.size())));
}

void print_tables(const Config& config, const std::vector<Result>& rows, const std::string& out,
                  std::set<std::string>& names) {
  const fs::path folder = fs::path(out) / "tables";
  fs::create_directories(folder);
  for (const TableSpec& spec : config.tables) {
    Table table = make_table(spec, config, rows);
    if (!names.insert(table.name).second)
      table.name = fs::path(config.path).stem().string() + "-" + table.name;
    fmt::print("{}\n", render(table, TableFormat::kMarkdown));
    for (const TableFormatTraits& traits : table_formats())
      write_text(folder / (table.name + std::string(traits.ending)), render(table, traits.format));
  }
}

std::string json_lines(const std::vector<Row>& rows) {
  std::string text;
  for (const Row& row : rows)
    text += row.dump(-1, ' ', false, Row::error_handler_t::replace) + "\n";
  return text;
}

std::string claims_text(const Config& config, const std::vector<ClaimVerdict>& verdicts) {
  return render(claims_table(config, verdicts), TableFormat::kMarkdown) + "\n" +
         render(groups_table(verdicts), TableFormat::kMarkdown);
}

void print_claims(const Config& config, const std::vector<Result>& rows, const std::string& out,
                  std::set<std::string>& names) {
  if (config.claims.empty()) return;
  const auto verdicts = judge_claims(config, rows);
  fmt::print("{}\n", render(claims_table(config, verdicts), TableFormat::kMarkdown));
  const fs::path folder = fs::path(out) / "claims";
  fs::create_directories(folder);
  std::string name = fs::path(config.path).stem().string();
  while (!names.insert(name).second) name += "-again";
  write_text(folder / (name + ".md"), claims_text(config, verdicts));
  write_text(folder / (name + ".jsonl"), json_lines(claims_rows(verdicts)));
}

/// Rows that are ok are kept as they are, also where they have more rounds than the configuration
/// allows now.
void note_longer_rows(const std::vector<Config>& configs, const std::vector<Result>& rows) {
  const auto latest = latest_by(rows, &Result::key);
  for (const Config& config : configs) {
    std::size_t longer = 0;
    for (const Cell& cell : config.cells) {
      const auto row = latest.find(cell.row_key());
      if (row != latest.end() && row->second.is_ok() && row->second.time)
        longer += row->second.time->rounds > config.max_rounds;
    }
    if (longer == 0) continue;
    fmt::print(stderr,
               "cvrbench: {}: {} cells that are done have more rounds than max_rounds allows ({}) "
               "and are kept; --force measures them again\n",
               volumes::printable(config.path), longer, config.max_rounds);
  }
}

/// Refuses a folder that has rows unless the choices say what becomes of them. Throws InputError.
void check_for_rows(const RunChoices& choices, const std::string& rows_path) {
  std::error_code error;
  if (choices.resume || choices.force || !fs::exists(rows_path, error) ||
      fs::file_size(rows_path, error) == 0)
    return;
  throw volumes::InputError(
      fmt::format("{}: expected no rows yet; --resume goes on with what is not done, --force "
                  "measures all again, "
                  "--out DIR writes elsewhere",
                  rows_path));
}

/// Says what of the rows before is kept though it need not be; how many of them are ignored.
std::size_t look_at_rows(const std::vector<Config>& configs, const RunChoices& choices,
                         const std::string& rows_path) {
  if (!choices.resume && !choices.force) return 0;
  const auto rows = load_rows(rows_path);
  if (choices.resume) note_longer_rows(configs, rows);
  return choices.force ? rows.size() : 0;
}

/// Measures one configuration after the other into a folder.
RunSummary measure_all(const std::vector<Config>& configs, const RunChoices& choices,
                       const Contender& contender, const std::string& rows_path,
                       std::size_t rows_before) {
  RunSummary all;
  for (const Config& config : configs) {
    const RunSummary summary =
        measure(config, choices, {contender}, choices.force && &config == &configs.front(),
                fmt::format("{} keeps what is done, --resume goes on", rows_path), rows_before);
    all.skipped += summary.skipped;
    all.add_ended(summary);
  }
  end_progress();
  return all;
}

/// Leaves a file below a folder, by a name that stays there.
void keep_file(const fs::path& folder, const fs::path& name, const fs::path& file) {
  const fs::path inside = name.lexically_normal();
  if (inside.is_absolute() || inside.begin()->string() == "..") return;
  fs::create_directories((folder / inside).parent_path());
  const volumes::Buffer bytes = read_file(file.string());
  write_file((folder / inside).string(), {bytes.data(), bytes.size()});
}

/// Leaves what was asked for beside the rows, as a source tree has it: configurations, descriptions
/// of data sets, scenes. So what a folder of results holds can be measured again elsewhere.
void keep_configurations(const std::vector<Config>& configs, const RunChoices& choices,
                         const std::string& out) {
  const fs::path folder = fs::path(out) / "configs";
  std::error_code error;
  for (const Config& config : configs) {
    const fs::path file(config.path);
    if (fs::equivalent(fs::absolute(file).parent_path(), folder, error)) continue;
    keep_file(folder, file.filename(), file);
    for (const auto& entry : fs::directory_iterator(find_catalogue(choices.datasets, config.path)))
      if (entry.path().extension() == ".yaml")
        keep_file(folder / "datasets", entry.path().filename(), entry.path());
    std::set<std::pair<std::string, std::string>> scenes;
    for (const Cell& cell : config.cells)
      if (cell.render) scenes.emplace(cell.render->scene, cell.render->scene_path);
    for (const auto& [scene, path] : scenes) {
      const bool by_path = fs::is_regular_file(file.parent_path() / scene, error);
      keep_file(folder, by_path ? fs::path(scene) : fs::path("scenes") / (scene + ".yaml"), path);
    }
  }
}

/// Writes and prints the tables and claims of all configurations from the rows of the folder.
void print_results(const std::vector<Config>& configs, const RunChoices& choices,
                   const std::string& out) {
  const auto rows = load_rows((fs::path(out) / "rows.jsonl").string());
  const Filter filter = parse_filter(choices.only);
  std::set<std::string> names, claim_names;
  for (const Config& config : configs) {
    Config kept = config;
    std::erase_if(kept.cells, [&](const Cell& cell) { return !filter.keeps(cell); });
    print_tables(kept, rows, out, names);
    print_claims(config, rows, out, claim_names);
  }
  write_text(fs::path(out) / "codecs.json", json_text(describe_codecs()));
  keep_configurations(configs, choices, out);
}

}  // namespace

int finish_run(const std::vector<Config>& configs, const RunChoices& choices,
               const RunSummary& summary) {
  const InterruptWatch watch;
  const std::string out = default_out(choices);
  const std::string rows_path = (fs::path(out) / "rows.jsonl").string();
  print_results(configs, choices, out);
  std::string counts = summary.skipped > 0 ? fmt::format("{} done before", summary.skipped) : "";
  for (const auto& [status, count] : summary.by_status)
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, status);
  fmt::print("Cells: {}. Rows: {}. Tables: {}\n", counts, rows_path,
             (fs::path(out) / "tables").string());
  return exit_code_of(summary, rows_path);
}

namespace {

int run(const Choices& choices, const Environment& environment) {
  if (choices.resume && choices.force)
    throw volumes::InputError("expected --resume or --force, found both");
  std::vector<Config> configs;
  for (const std::string& path : choices.configs) configs.push_back(load(choices, path));
  const std::string out = default_out(choices);
  const std::string rows_path = (fs::path(out) / "rows.jsonl").string();
  const auto lock = RunLock::take(out);  // until the tables of all configurations are written
  check_for_rows(choices, rows_path);
  return finish_run(configs, choices,
                    measure_all(configs, choices, {environment.program, out}, rows_path,
                                look_at_rows(configs, choices, rows_path)));
}

/// What a plan says of one configuration in the end.
struct PlanTotals {
  std::map<Decision, std::size_t> counts;
  double seconds = 0;
  std::uint64_t memory = 0;
  bool modelled = false;

  void add(const PlannedCell& planned) {
    ++counts[planned.decision];
    if (planned.decision != Decision::kRun) return;
    seconds += planned.expected_seconds;
    memory = std::max(memory, planned.expected_memory);
    modelled = modelled || !planned.expected_from_rows;
  }
};

double mebibytes(std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

void print_planned(const PlannedCell& planned) {
  fmt::print("{:<12} {}  {}", name_of(planned.decision), planned.id, planned.cell.describe());
  if (!planned.reason.empty()) fmt::print("  ({})", volumes::printable(planned.reason));
  if (planned.decision == Decision::kRun) {
    fmt::print("  {} {:.1f} s, {:.0f} MiB", planned.expected_from_rows ? "as before" : "about",
               planned.expected_seconds, mebibytes(planned.expected_memory));
  }
  fmt::print("\n");
}

int plan(const Choices& choices) {
  const auto rows = load_rows((fs::path(default_out(choices)) / "rows.jsonl").string());
  for (const std::string& path : choices.configs) {
    const Config config = load(choices, path);
    const auto cells = plan_cells(config, parse_filter(choices.only), {choices.data, choices.cache},
                                  rows, choices.force);
    if (cells.empty())
      throw volumes::InputError(
          fmt::format("{}: expected cells that --only {} keeps, found none of {}", config.path,
                      fmt::join(choices.only, " --only "), config.cells.size()));
    PlanTotals totals;
    for (const PlannedCell& planned : cells) {
      totals.add(planned);
      print_planned(planned);
    }
    fmt::print(
        "{}: {} to run, {} done, {} unsupported, {} with missing data; about {:.0f} s{}, up to "
        "{:.0f} MiB per process\n",
        volumes::printable(path), totals.counts[Decision::kRun], totals.counts[Decision::kDone],
        totals.counts[Decision::kUnsupported], totals.counts[Decision::kDataMissing],
        totals.seconds,
        totals.modelled
            ? " (of cells without rows: 50 Mvoxel/s and thread, 0.5 s a round of random access)"
            : "",
        mebibytes(totals.memory));
  }
  return kExitOk;
}

int claims(const Choices& choices) {
  const Config config = load(choices, choices.configs.front());
  if (config.claims.empty())
    throw volumes::InputError(fmt::format("{}: expected the key claims, found none", config.path));
  const auto verdicts = judge_claims(config, rows_in(choices.out));
  fmt::print("{}", choices.format == "jsonl" ? json_lines(claims_rows(verdicts))
                                             : claims_text(config, verdicts));
  if (std::ranges::any_of(verdicts,
                          [](const ClaimVerdict& v) { return v.verdict != Verdict::kUnchecked; }))
    return kExitOk;
  return end_with_nothing(kExitCheckFailed,
                          fmt::format("{}: none of {} claims can be checked with the rows of {}",
                                      config.path, verdicts.size(), choices.out));
}

int table(const Choices& choices) {
  const auto format = table_format_from_name(choices.format);
  const Config config = load(choices, choices.configs.front());
  const auto rows = rows_in(choices.out);
  bool found = false;
  std::vector<std::string> names;
  for (const TableSpec& spec : config.tables) {
    names.push_back(spec.name);
    if (!choices.table.empty() && spec.name != choices.table) continue;
    fmt::print("{}{}", found ? "\n" : "", render(make_table(spec, config, rows), *format));
    found = true;
  }
  if (!found)
    throw volumes::InputError(
        choices.table.empty()
            ? fmt::format("{}: expected the key tables, found none", config.path)
            : fmt::format("{}: expected a table '{}', found none{}", config.path, choices.table,
                          volumes::did_you_mean(choices.table, names)));
  const auto latest = latest_by(rows, &Result::key);
  const auto is_measured = [&](const Cell& cell) {
    const auto row = latest.find(cell.row_key());
    return row != latest.end() && row->second.is_ok();
  };
  if (std::ranges::any_of(config.cells, is_measured)) return kExitOk;
  return end_with_nothing(kExitCheckFailed,
                          fmt::format("{}: no cell of {} is ok there", choices.out, config.path));
}

}  // namespace

void add_run_commands(CLI::App& app, const Environment& environment, int& exit_code) {
  auto c = std::make_shared<Choices>();
  c->data = environment.data;
  c->cache = environment.cache;

  auto* running = app.add_subcommand(
      "run",
      "Measures the cells of configurations; appends rows to DIR/rows.jsonl and prints tables");
  running->add_option("configs", c->configs, "configuration files")->required();
  running->add_option(
      "--out", c->out,
      "folder for rows and tables (default: results/local/NAME of the first configuration)");
  running->add_option("--device", c->device,
                      "that draws: index, or part of a name or type ('list devices')");
  running->add_flag("--resume", c->resume, "keep the rows that are ok and measure the rest");
  running->add_flag("--force", c->force,
                    "measure all again; new rows count, old ones stay in the file");
  add_config_options(*running, *c);
  add_data_options(*running, *c);
  running->callback([c, &environment, &exit_code] { exit_code = run(*c, environment); });

  auto* planning = app.add_subcommand(
      "plan",
      "Tells what run would do: cells to run, done, unsupported, without data; time and memory");
  planning->add_option("configs", c->configs, "configuration files")->required();
  planning->add_option("--out", c->out, "folder whose rows count as done (default: as run)");
  planning->add_flag("--force", c->force, "as run");
  add_config_options(*planning, *c);
  add_data_options(*planning, *c);
  planning->callback([c, &exit_code] { exit_code = plan(*c); });

  auto* tabling = app.add_subcommand(
      "table", "Prints a configuration's tables from rows, measured beside published figures");
  tabling->add_option("config", c->configs, "configuration file")->required()->expected(1);
  tabling->add_option("--results", c->out, "folder with rows.jsonl")->required();
  tabling->add_option("--format", c->format, "md | csv | latex | json (an object a table)")
      ->check(one_of({"md", "csv", "latex", "json"}));
  tabling->add_option("--name", c->table, "only the table of this name");
  add_config_options(*tabling, *c);
  tabling->callback([c, &exit_code] { exit_code = table(*c); });

  auto* judging = app.add_subcommand(
      "claims", "Prints which claims of papers a configuration's rows confirm and refute");
  judging->add_option("config", c->configs, "configuration file")->required()->expected(1);
  judging->add_option("--results", c->out, "folder with rows.jsonl")->required();
  judging->add_option("--format", c->format, "md | jsonl")->check(one_of({"md", "jsonl"}));
  add_config_options(*judging, *c);
  judging->callback([c, &exit_code] { exit_code = claims(*c); });

  auto* working = app.add_subcommand("worker", "");
  working->group("");
  working->callback(
      [&environment, &exit_code] { exit_code = serve_worker(std::cin, *environment.hooks); });
}

}  // namespace cvr::experiments::cli
