// pack, verify: results that a paper can cite, made and checked by plots/pack.py and verify.py
#include <fmt/format.h>

#include <filesystem>

#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/cli/python_program.hpp"
#include "experiments/run/worker_process.hpp"
#include "volumes/io/file.hpp"

namespace cvr::experiments::cli {

namespace {

namespace fs = std::filesystem;

struct PackChoices {
  std::string run, output, title, licence, pack, data, cache;
  std::vector<std::string> creators;
  std::uint64_t cells = 6, seed = 1;
  bool all = false, json = false;
};

constexpr std::uint64_t kMostCells = 1'000'000;
constexpr std::uint64_t kLargestSeed = std::uint64_t{1} << 53;

int pack(const PackChoices& c, const Environment& environment) {
  InterruptWatch watch;
  std::error_code error;
  if (!fs::is_directory(c.run, error))
    throw volumes::InputError(
        fmt::format("{}: expected a folder with rows.jsonl, found none", c.run));
  std::vector<std::string> inputs;
  for (const char* name : {"rows.jsonl", "rows.jsonl.zst", "codecs.json", "report.html", "tables",
                           "claims", "pictures", "configs"})
    inputs.push_back((fs::path(c.run) / name).string());
  volumes::refuse_to_replace({c.output}, inputs);
  volumes::check_output(c.output);
  std::vector<std::string> arguments{"--run",  c.run,       "-o",
                                     c.output, "--program", path_for_children(environment.program)};
  if (!c.title.empty()) arguments.insert(arguments.end(), {"--title", c.title});
  if (!c.licence.empty()) arguments.insert(arguments.end(), {"--licence", c.licence});
  for (const std::string& creator : c.creators)
    arguments.insert(arguments.end(), {"--creator", creator});
  try {
    return run_python({"pack.py", kReportModules}, arguments, watch);
  } catch (const EnvironmentError&) {  // without them a pack has no page
    return run_python({"pack.py", {}}, arguments, watch);
  }
}

int verify(const PackChoices& c, const Environment& environment) {
  InterruptWatch watch;
  std::error_code error;
  if (!fs::is_regular_file(c.pack, error))
    throw volumes::InputError(fmt::format("{}: expected a pack, found no file", c.pack));
  std::vector<std::string> arguments{"--pack",    c.pack,
                                     "--cells",   std::to_string(c.cells),
                                     "--seed",    std::to_string(c.seed),
                                     "--program", path_for_children(environment.program)};
  if (!c.data.empty()) arguments.insert(arguments.end(), {"--data", c.data});
  if (!c.cache.empty()) arguments.insert(arguments.end(), {"--cache", c.cache});
  if (c.all) arguments.emplace_back("--all");
  if (c.json) arguments.emplace_back("--json");
  return run_python({"verify.py", {}}, arguments, watch);
}

}  // namespace

void add_pack_commands(CLI::App& app, const Environment& environment, int& exit_code) {
  auto c = std::make_shared<PackChoices>();
  c->data = environment.data;
  auto* packing = app.add_subcommand(
      "pack",
      "Makes one zip of a results folder that a paper can cite, an RO-Crate: rows, configuration, "
      "tables, report, hashes, machine, licences; no volumes");
  packing->add_option("run", c->run, "folder with rows.jsonl")->required();
  packing->add_option("-o,--output", c->output, "the zip")->required();
  packing->add_option("--title", c->title, "what it is");
  packing->add_option("--licence", c->licence, "of the results (default: CC BY 4.0)");
  packing->add_option("--creator", c->creators, "name of who measured; may be repeated")
      ->allow_extra_args(false);
  packing->callback([c, &environment, &exit_code] { exit_code = pack(*c, environment); });
  auto* verifying = app.add_subcommand(
      "verify",
      "Checks the hashes of a pack, measures a random sample of its cells again, and says which "
      "exact figures agree and how times compare");
  verifying->add_option("pack", c->pack, "a zip that 'pack' made")->required();
  verifying->add_option("--cells", c->cells, "how many cells (default: 6)")
      ->check(integer_in(1, kMostCells));
  verifying->add_option("--seed", c->seed, "of the sample (default: 1)")
      ->check(integer_in(0, kLargestSeed));
  verifying->add_flag("--all", c->all, "every cell");
  verifying->add_option("--data", c->data, "folder that ${CVRBENCH_DATA} stands for");
  verifying->add_option("--cache", c->cache, "folder for raw copies of data sets");
  verifying->add_flag("--json", c->json, "one object on standard output");
  verifying->callback([c, &environment, &exit_code] { exit_code = verify(*c, environment); });
}

}  // namespace cvr::experiments::cli
