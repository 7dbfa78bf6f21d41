// generate, convert
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <thread>

#include "experiments/cli/arguments.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/interruption.hpp"
#include "volumes/generators/generator.hpp"
#include "volumes/io/io.hpp"
#include "volumes/number_text.hpp"

namespace cvr::experiments::cli {

namespace {

struct GenerateOptions {
  std::string kind, size, out;
  std::uint64_t seed = 1;
  unsigned threads = std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::string> parameters;
};

std::map<std::string, double> parse_parameters(const std::vector<std::string>& assignments) {
  std::map<std::string, double> parameters;
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0)
      throw volumes::InputError(
          fmt::format("-p {}: expected NAME=NUMBER, found no '='", assignment));
    const auto value = volumes::parse_real(std::string_view(assignment).substr(equals + 1));
    if (!value) {
      throw volumes::InputError(fmt::format("-p {}: expected NAME=NUMBER, {}", assignment,
                                            volumes::found_number(assignment.substr(equals + 1))));
    }
    if (!parameters.emplace(assignment.substr(0, equals), *value).second) {
      throw volumes::InputError(fmt::format("-p {}: expected each parameter once", assignment));
    }
  }
  return parameters;
}

void generate(const GenerateOptions& options) {
  if (!volumes::is_volume_path(options.out)) {
    throw volumes::InputError(fmt::format(
        "{}: expected the name of a volume (.h5, .nrrd, .nhdr, .nii, .nii.gz, .raw or a folder)",
        options.out));
  }
  const auto source =
      volumes::make_generator(options.kind, parse_extent(options.size), options.seed,
                              parse_parameters(options.parameters), options.threads);
  volumes::write_volume(options.out, *source);
}

struct ConvertOptions {
  std::string in, out;
  VolumeChoices volume;
};

void convert(const ConvertOptions& options) {
  if (!volumes::is_volume_path(options.out)) {
    throw volumes::InputError(fmt::format(
        "{}: expected the name of a volume (.h5, .nrrd, .nhdr, .nii, .nii.gz, .raw or a folder)",
        options.out));
  }
  volumes::write_volume(options.out, *volumes::open_volume(options.in, options.volume.options()));
}

}  // namespace

void add_volume_commands(CLI::App& app, int& exit_code) {
  std::vector<std::string_view> kinds;
  for (const auto& generator : volumes::all_generators()) kinds.push_back(generator.kind);
  auto made = std::make_shared<GenerateOptions>();
  auto* generating = app.add_subcommand(
      "generate", "Makes a volume: the same for the same kind, size, seed and parameters");
  generating->add_option("kind", made->kind, fmt::format("{}", fmt::join(kinds, " | ")))
      ->required();
  generating->add_option("--size", made->size, "X,Y,Z in voxels")->required();
  generating->add_option("--seed", made->seed, "seed")
      ->required()
      ->check(integer_in(0, UINT64_MAX));
  generating->add_option("-p", made->parameters, "NAME=NUMBER, a parameter of the generator")
      ->allow_extra_args(false);
  generating->add_option("--threads", made->threads, "threads (the bytes do not depend on it)")
      ->check(integer_in(1, kMostThreads));
  generating->add_option("-o", made->out, "volume file to write")->required();
  std::string footer = "Parameters:";
  for (const auto& generator : volumes::all_generators()) {
    footer += fmt::format("\n  {}: {}", generator.kind, generator.summary);
    for (const auto& p : generator.parameters) {
      footer += fmt::format("\n    {}={}  ({}..{})  {}", p.name, p.default_value, p.minimum,
                            p.maximum, p.description);
    }
  }
  generating->footer(footer);
  generating->callback([made, &exit_code] {
    const InterruptWatch watch;
    generate(*made);
    exit_code = kExitOk;
  });

  auto converted = std::make_shared<ConvertOptions>();
  auto* converting = app.add_subcommand(
      "convert", "Copies a volume from one file format to another, by the names");
  converting->add_option("in", converted->in, "volume file")->required();
  converting->add_option("out", converted->out, "volume file to write")->required();
  add_volume_choices(*converting, converted->volume);
  converting->callback([converted, &exit_code] {
    const InterruptWatch watch;
    convert(*converted);
    exit_code = kExitOk;
  });
}

}  // namespace cvr::experiments::cli
