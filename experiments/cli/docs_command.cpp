// docs: fills the markers of documents from rows, and makes the pages of runs
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "experiments/analysis/markers.hpp"
#include "experiments/analysis/metrics.hpp"
#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "experiments/cli/run_choices.hpp"
#include "experiments/run/load_config.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace {

namespace fs = std::filesystem;

struct DocsChoices {
  std::vector<std::string> files;
  std::string evidence = "results/evidence", pages;
  bool check = false;
};

std::string text_of(const fs::path& path) {
  const volumes::Buffer bytes = read_file(path.string());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Runs are read when they are asked for, each once.
class EvidenceFolder {
 public:
  explicit EvidenceFolder(std::string folder) : folder_(std::move(folder)) {}

  const Evidence& of(const std::string& name) {
    const auto known = runs_.find(name);
    return known != runs_.end() ? known->second : runs_.emplace(name, read(name)).first->second;
  }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (fs::is_regular_file(config_of(name))) all.push_back(name);
    }
    std::ranges::sort(all);
    return all;
  }

 private:
  fs::path config_of(const std::string& name) const {
    return fs::path(folder_) / name / (name + ".yaml");
  }

  Evidence read(const std::string& name) const {
    const fs::path config = config_of(name);
    std::error_code error;
    if (name.find('/') != std::string::npos || !fs::is_regular_file(config, error))
      throw volumes::InputError(
          fmt::format("expected the configuration {}, found none", config.string()));
    RunChoices choices;
    const fs::path folder = config.parent_path(), readme = folder / "README.md";
    return {name, load(choices, config.string()), rows_in(folder.string()),
            fs::is_regular_file(readme, error) ? text_of(readme) : "# " + name + "\n"};
  }

  std::string folder_;
  std::map<std::string, Evidence> runs_;
};

/// The first line in which two texts differ.
std::size_t differing_line(const std::string& a, const std::string& b) {
  const auto [end, ignored] = std::ranges::mismatch(a, b);
  return 1 + static_cast<std::size_t>(std::count(a.begin(), end, '\n'));
}

/// Writes what has changed and names it, or with --check says where it differs. How many did.
class Documents {
 public:
  explicit Documents(bool check) : check_(check) {}

  void put(const std::string& path, const std::string& text) {
    std::error_code error;
    const std::string before = fs::exists(path, error) ? text_of(path) : "";
    if (before == text) return;
    ++differ_;
    if (check_) {
      fmt::print(stderr, "{}:{}: differs from its rows; scripts/make-docs writes it anew\n",
                 volumes::printable(path), differing_line(before, text));
      return;
    }
    const fs::path folder = fs::path(path).parent_path();
    if (!folder.empty()) fs::create_directories(folder);
    write_file(path, std::as_bytes(std::span(text.data(), text.size())));
    fmt::print("{}\n", volumes::printable(path));
  }
  std::size_t differ() const { return differ_; }

 private:
  bool check_;
  std::size_t differ_ = 0;
};

/// Paths, from the pages, of what lies in figures/NAME beside them.
std::vector<std::string> figures_of(const std::string& pages, const std::string& name) {
  std::vector<std::string> found;
  std::error_code error;
  const fs::path folder = fs::path("figures") / name;
  for (const auto& entry : fs::directory_iterator(pages / folder, error))
    if (entry.path().extension() == ".svg")
      found.push_back((folder / entry.path().filename()).string());
  std::ranges::sort(found);
  return found;
}

/// The list of all pages.
std::string index_of(EvidenceFolder& evidence, const std::vector<std::string>& names) {
  std::string text =
      "# Results\n\nOne page for each run of [results/evidence](../../results/evidence), made from "
      "its rows\nby `scripts/make-docs`.\n\n| run | what | rows |\n|:--|:--|--:|\n";
  for (const std::string& name : names) {
    const Evidence& run = evidence.of(name);
    text += fmt::format("| [{0}]({0}.md) | {1} | {2} |\n", name, run.config.title, run.rows.size());
  }
  return text;
}

int docs(const DocsChoices& c) {
  const InterruptWatch watch;
  if (!fs::is_directory(c.evidence))
    throw volumes::InputError(fmt::format("--evidence {}: expected a folder of runs, found none",
                                          volumes::printable(c.evidence)));
  EvidenceFolder evidence(c.evidence);
  Documents documents(c.check);
  const auto source = [&](const std::string& name) -> const Evidence& { return evidence.of(name); };
  for (const std::string& file : c.files)
    documents.put(file, fill_markers(file, text_of(file), source, metric_names()));
  if (!c.pages.empty()) {
    const auto names = evidence.names();
    for (const std::string& name : names)
      documents.put((fs::path(c.pages) / (name + ".md")).string(),
                    evidence_page(evidence.of(name), figures_of(c.pages, name)));
    documents.put((fs::path(c.pages) / "README.md").string(), index_of(evidence, names));
  }
  return c.check && documents.differ() > 0 ? kExitCheckFailed : kExitOk;
}

}  // namespace

void add_docs_command(CLI::App& app, int& exit_code) {
  auto c = std::make_shared<DocsChoices>();
  auto* command = app.add_subcommand(
      "docs", "Writes figures and tables between the markers of documents from rows");
  command->add_option("files", c->files, "documents (Markdown)");
  command->add_option("--evidence", c->evidence,
                      "folder of runs: each a folder NAME with NAME.yaml and rows.jsonl or "
                      "rows.jsonl.zst (default: results/evidence)");
  command->add_option("--pages", c->pages, "folder for one page for each run, and their list");
  command->add_flag("--check", c->check,
                    "changes nothing; says what differs from the rows, and exits with 1 then");
  command->callback([c, &exit_code] { exit_code = docs(*c); });
}

}  // namespace cvr::experiments::cli
