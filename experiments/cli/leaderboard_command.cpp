// leaderboard: one static site of many results, made by plots/leaderboard.py
#include <fmt/format.h>

#include <filesystem>

#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/cli/python_program.hpp"

namespace cvr::experiments::cli {

namespace {

struct LeaderboardChoices {
  std::vector<std::string> results;  ///< folders with rows, or packs
  std::string output, title;
};

int leaderboard(const LeaderboardChoices& c, const Environment& environment) {
  InterruptWatch watch;
  std::error_code error;
  for (const std::string& place : c.results) {
    if (!std::filesystem::exists(place, error))
      throw volumes::InputError(
          fmt::format("{}: expected a results folder or a pack, found none", place));
  }
  std::vector<std::string> arguments{"-o", c.output, "--program",
                                     path_for_children(environment.program)};
  if (!c.title.empty()) arguments.insert(arguments.end(), {"--title", c.title});
  arguments.emplace_back("--");
  arguments.insert(arguments.end(), c.results.begin(), c.results.end());
  return run_python({"leaderboard.py", {"matplotlib", "jinja2"}}, arguments, watch);
}

}  // namespace

void add_leaderboard_command(CLI::App& app, const Environment& environment, int& exit_code) {
  auto c = std::make_shared<LeaderboardChoices>();
  auto* command = app.add_subcommand(
      "leaderboard",
      "Makes one static site of many results: leaderboards, a page for each data set and codec, "
      "and the rows behind every figure");
  command
      ->add_option("results", c->results,
                   "folders with rows.jsonl or rows.jsonl.zst, or packs (a zip with rows.jsonl)")
      ->required();
  command
      ->add_option("-o,--output", c->output,
                   "folder of the site; replaced where it is empty or a site made by this command")
      ->required();
  command->add_option("--title", c->title, "heading of the site");
  command->callback([c, &environment, &exit_code] { exit_code = leaderboard(*c, environment); });
}

}  // namespace cvr::experiments::cli
