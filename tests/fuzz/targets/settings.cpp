// What the command line says in small texts: the lines of the input as --set, as --only, and as
// parameters of a codec.
#include "codecs/registry.hpp"
#include "experiments/cli/run_choices.hpp"
#include "experiments/run/load_config.hpp"
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(settings, input) {
  using namespace cvr::experiments;
  static const cvr::fuzz::InputFolder kFolder;
  static const Catalogue kCatalogue = Catalogue::from_folder(CVR_SOURCE_DIR "/configs/datasets");
  static const std::string kPath = kFolder.write(
      "c.yaml",
      "title: t\nmatrix:\n  - datasets: [{generator: cells, extent: [9, 8, 7], name: g}]\n"
      "    codecs: [raw, {id: csgv-rans, parameters: {brick: [16, 32]}}]\n    stages: [encode, "
      "decode]\n"
      "tables: [{name: n, title: t, rows: [dataset, codec], columns: [rate]}]\n");
  static const Config kConfig = load_config(kPath, kCatalogue, {});
  std::vector<std::string> lines;
  std::string_view text = cvr::fuzz::text_of(input);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  try {
    load_config(kPath, kCatalogue, lines);
  } catch (const cvr::volumes::InputError&) {
  }
  try {
    const Filter filter = cli::parse_filter(lines);
    for (const Cell& cell : kConfig.cells) filter.keeps(cell);
  } catch (const cvr::volumes::InputError&) {
  }
  for (const auto* codec : cvr::codecs::all_codecs()) {
    const auto parsed = cvr::codecs::Parameters::parse(codec->parameters(), lines);
    if (!parsed) continue;
    // The canonical form says the same.
    const auto again = cvr::codecs::Parameters::parse(
        codec->parameters(), cvr::codecs::split_canonical(parsed->canonical()));
    if (!again || again->canonical() != parsed->canonical()) std::abort();
  }
}
