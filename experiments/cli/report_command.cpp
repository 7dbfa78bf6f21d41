// report: one HTML page of results folders, made by plots/report.py
#include "experiments/cli/report_command.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/cli/python_program.hpp"
#include "volumes/io/file.hpp"

namespace cvr::experiments::cli {

namespace {

namespace fs = std::filesystem;

/// What the report reads of results folders; the page may lie beside it.
std::vector<std::string> inputs_of(const ReportChoices& c) {
  std::vector<std::string> inputs;
  for (const fs::path folder : c.results) {
    for (const char* name : {"rows.jsonl", "codecs.json", "tables", "claims", "pictures"})
      inputs.push_back((folder / name).string());
  }
  return inputs;
}

}  // namespace

int report(const ReportChoices& c, const Environment& environment) {
  InterruptWatch watch;
  std::error_code error;
  for (const std::string& folder : c.results) {
    if (!fs::is_directory(folder, error))
      throw volumes::InputError(
          fmt::format("--results {}: expected a folder with rows.jsonl, found none", folder));
  }
  volumes::refuse_to_replace({c.output}, inputs_of(c));
  volumes::check_output(c.output);
  std::vector<std::string> arguments{"-o", c.output, "--program",
                                     path_for_children(environment.program)};
  for (const std::string& folder : c.results)
    arguments.insert(arguments.end(), {"--results", folder});
  if (!c.figures.empty()) arguments.insert(arguments.end(), {"--figures", c.figures});
  if (!c.title.empty()) arguments.insert(arguments.end(), {"--title", c.title});
  if (fs::is_directory(c.store, error)) arguments.insert(arguments.end(), {"--store", c.store});
  return run_python({"report.py", kReportModules}, arguments, watch);
}

void add_report_command(CLI::App& app, const Environment& environment, int& exit_code) {
  auto c = std::make_shared<ReportChoices>();
  c->store = history_folder(environment);
  auto* command = app.add_subcommand("report",
                                     "Makes one self-contained HTML page of results: summary, "
                                     "tables, claims, figures, images, provenance");
  command
      ->add_option("--results", c->results,
                   "folders with rows.jsonl; what a run left in tables/, claims/ and pictures/ "
                   "beside it is used too")
      ->required();
  command->add_option("-o,--output", c->output, "the page")->required();
  command->add_option("--figures", c->figures,
                      "folder for each figure as PDF and SVG, one column of a paper wide");
  command->add_option("--title", c->title, "heading of the page");
  command->add_option("--store", c->store, "folder of the history");
  command->callback([c, &environment, &exit_code] { exit_code = report(*c, environment); });
}

}  // namespace cvr::experiments::cli
