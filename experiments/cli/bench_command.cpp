// bench: every codec that takes a volume file, without a configuration
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <span>

#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/report_command.hpp"
#include "experiments/cli/run_choices.hpp"
#include "experiments/run/bench_config.hpp"
#include "experiments/run/run_folder.hpp"
#include "gpu/vulkan/device.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace {

namespace fs = std::filesystem;

constexpr double kMostMinutes = 1e5;
constexpr double kOverShare = 4;  // most cells take far less than an equal share
constexpr double kLeastTimeout = 2, kImageTimeout = 60;  // seconds of a cell

struct BenchChoices {
  std::vector<std::string> files;
  VolumeChoices volume;
  double minutes = 2;
  bool no_images = false;
  RunChoices run;
};

/// What is measured of a file, before it takes its time; u8 and u16 may be either kind.
void announce(const std::string& file, const BenchVolume& volume) {
  const volumes::VolumeInfo& info = volume.info;
  const bool either = info.type == volumes::VoxelType::kU8 || info.type == volumes::VoxelType::kU16;
  fmt::print(stderr, "{}: {} {} {}{}\n", volumes::printable(file), to_string(info.extent),
             name_of(info.type), name_of(info.kind),
             volume.options.kind || !either ? ""
             : info.kind == volumes::VolumeKind::kLabels
                 ? " (if the voxels are measured values, say so with --kind scalars)"
                 : " (if the voxels are labels, say so with --kind labels)");
}

std::vector<BenchVolume> open_volumes(const BenchChoices& choices) {
  std::vector<BenchVolume> volumes;
  std::set<std::string> names;
  for (const std::string& file : choices.files) {
    BenchVolume volume = open_for_bench(file, choices.volume.options());
    const std::string name = volume.name;
    for (unsigned n = 2; !names.insert(volume.name).second; ++n)
      volume.name = fmt::format("{}-{}", name, n);
    announce(file, volume);
    volumes.push_back(std::move(volume));
  }
  return volumes;
}

bool can_draw() {
  for (const gpu::DeviceReport& device : gpu::list_devices()) {
    if (device.rejected.empty()) return true;
  }
  return false;
}

/// The page beside the rows; that it cannot be made here is no failure of what was measured.
void make_report(const RunChoices& choices, const Environment& environment) {
  fmt::print("\n");
  std::fflush(stdout);
  ReportChoices report_choices;
  report_choices.results = {choices.out};
  report_choices.output = (fs::path(choices.out) / "report.html").string();
  report_choices.store = history_folder(environment);
  try {
    report(report_choices, environment);
  } catch (const EnvironmentError& error) {
    fmt::print(stderr, "cvrbench: no report: {}\n", error.what());
  }
}

int bench(BenchChoices choices, const Environment& environment) {
  std::vector<BenchVolume> volumes = open_volumes(choices);
  RunChoices& run_choices = choices.run;
  if (run_choices.out.empty())
    run_choices.out = (fs::path("results/local") / ("bench-" + volumes.front().name)).string();
  const auto lock = RunLock::take(run_choices.out);
  const auto in_folder = [&](const char* name) {
    return (fs::path(run_choices.out) / name).string();
  };
  const std::string config_path = in_folder("bench.yaml"), rows_path = in_folder("rows.jsonl");
  run_choices.configs = {config_path};
  const std::size_t rows_before = load_rows(rows_path).size();
  const double share =
      kOverShare * 60 * choices.minutes / static_cast<double>(bench_cells(volumes));
  const auto measure_volumes = [&](double timeout, bool redo) {
    const std::string text = bench_config(volumes, timeout);
    write_file(config_path, std::as_bytes(std::span(text.data(), text.size())));
    return measure(load(run_choices, config_path), run_choices,
                   {{environment.program, run_choices.out}}, redo,
                   fmt::format("{} keeps what is done", rows_path), rows_before);
  };
  RunSummary summary = measure_volumes(std::max(share, kLeastTimeout), true);
  if (!choices.no_images && can_draw()) {
    const auto rows = load_rows(rows_path);
    for (BenchVolume& volume : volumes) volume.drawn_codec = codec_to_draw(volume, rows);
    if (std::ranges::any_of(volumes, [](const auto& v) { return !v.drawn_codec.empty(); })) {
      run_choices.only = {"stage=render"};
      summary.add_ended(measure_volumes(std::max(share, kImageTimeout), false));
    }
  }
  end_progress();
  run_choices.only.clear();
  const int code = finish_run({load(run_choices, config_path)}, run_choices, summary);
  make_report(run_choices, environment);
  fmt::print("Configuration: {}\n", volumes::printable(config_path));
  return code;
}

}  // namespace

void add_bench_command(CLI::App& app, const Environment& environment, int& exit_code) {
  auto c = std::make_shared<BenchChoices>();
  c->run.data = environment.data;
  c->run.cache = environment.cache;
  auto* benching = app.add_subcommand(
      "bench",
      "Measures volume files with every codec that takes them: size, speed, exactness, images; "
      "verifies all, prints one table and the answers, leaves rows, report.html and the "
      "configuration");
  benching->add_option("files", c->files, "volume files")->required();
  benching
      ->add_option("--minutes", c->minutes,
                   "what encoding, decoding and access may take in all, about (default: 2)")
      ->check(number_in(0.01, kMostMinutes));
  benching->add_option(
      "--out", c->run.out,
      "folder for all of it (default: results/local/bench-NAME of the first file)");
  benching->add_flag("--no-images", c->no_images, "no images, and no times of frames");
  add_volume_choices(*benching, c->volume);
  benching->add_option("--device", c->run.device,
                       "that draws: index, or part of a name or type ('list devices')");
  benching->add_option(
      "--cache", c->run.cache,
      "folder for raw copies of volumes (default: cvrbench in the user's cache folder)");
  benching->callback([c, &environment, &exit_code] { exit_code = bench(*c, environment); });
}

}  // namespace cvr::experiments::cli
