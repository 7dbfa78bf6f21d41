#include "experiments/config/key_documents.hpp"

#include "experiments/config/block.hpp"
#include "experiments/config/config.hpp"
#include "experiments/config/dataset_keys.hpp"
#include "experiments/config/marker_spec.hpp"
#include "experiments/config/published.hpp"
#include "experiments/config/scene_file.hpp"

namespace cvr::experiments {

namespace {

struct Section {
  std::string title, intro;
  std::vector<KeyInfo> keys;
};

std::vector<Section> sections_of(const Vocabulary& vocabulary) {
  static const Catalogue kNone;
  const MetricNames metrics = vocabulary.metrics;
  return {
      {"A configuration",
       "`cvrbench run FILE.yaml`. `--set KEY=VALUE` wins over the file: for the keys with simple "
       "values (`--set rounds=3`), for a key of blocks in every block that may have it (`--set "
       "frames=100`), and for a path of keys and places of lists, from 0, where `*` stands for all "
       "(`--set 'matrix.*.size=1920,1080'`).",
       infos_of(config_keys("", kNone, vocabulary))},
      {"A block of the matrix",
       "The cells of a block are the product of its lists. The keys from `scenes` on are those of "
       "the stage render; where a list is allowed, it multiplies the cells. They may stand with an "
       "entry of `codecs` too and, for single data sets, under `per_dataset`: the codec's win over "
       "the data set's, and those over the block's.",
       infos_of(block_keys({kNone, vocabulary.stages, ""}))},
      {"A codec of a block", "In place of an id: a map.",
       codec_entry_keys({kNone, vocabulary.stages, ""})},
      {"A data set of a block, chosen", "In place of a name: a described data set, changed.",
       infos_of(choice_keys(kNone))},
      {"A data set of a block, by its file", "In place of a name: a volume without a description.",
       infos_of(file_keys(""))},
      {"A data set of a block, generated", "In place of a name: a volume that a generator makes.",
       infos_of(generated_keys())},
      {"A table", "An entry of `tables`; one of `columns`, `bd_psnr` and `pivot` is required.",
       infos_of(table_keys("", metrics))},
      {"`pivot` of a table", "", infos_of(pivot_keys(metrics))},
      {"`published` of a table or a claim", "", infos_of(published_place_keys(""))},
      {"A claim",
       "An entry of `claims`. A side matches one line of a table in each group, or the lines of a "
       "curve; anything else is an error of the configuration.",
       infos_of(claim_keys("", metrics))},
      {"A description of a data set",
       "Files of `configs/datasets` are maps from names to descriptions; the names of all files "
       "together are unique. A description has a `file`, a `generator`, or a file with a "
       "`stand_in`.",
       infos_of(description_keys(""))},
      {"A scene", "Files of `configs/scenes`.", infos_of(scene_keys())},
      {"A camera of a scene's `keys`", "", infos_of(camera_keys())},
      {"A material of a scene", "", infos_of(material_keys())},
      {"A point of a transfer function", "", infos_of(transfer_keys())},
      {"A file of published figures", "Files of `results/published`.",
       infos_of(published_file_keys())},
      {"A marker of a document",
       "`<!--cvrbench {KEYS}-->` .. `<!--/cvrbench-->` ([evidence.md](evidence.md)). One of the "
       "keys "
       "from `value` to `claims` says what stands there.",
       infos_of(marker_keys("", metrics))},
      {"A published table", "", infos_of(published_table_keys())},
      {"A published figure", "", infos_of(published_figure_keys())},
  };
}

/// A cell of a Markdown table.
std::string cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2)
    text.insert(at, 1, '\\');
  return text;
}

}  // namespace

std::string configuration_page(const Vocabulary& vocabulary) {
  std::string page =
      "# Keys of configurations\n\n"
      "This page is made by `cvrbench list config`. Unknown and repeated keys are errors with "
      "their line and column. Editors check and complete a file that begins with "
      "`# yaml-language-server: $schema=PATH/results/schema/config.schema.json`.\n";
  for (const Section& section : sections_of(vocabulary)) {
    page += fmt::format("\n## {}\n\n", section.title);
    if (!section.intro.empty()) page += section.intro + "\n\n";
    page += "| Key | Value | Default | Meaning |\n|:--|:--|:--|:--|\n";
    for (const KeyInfo& key : section.keys) {
      const std::string_view former = former_name(key.name);
      page += fmt::format(
          "| `{}` | {} | {} | {}{} |\n", key.name, cell(key.values),
          key.required ? "required" : cell(key.fallback), cell(key.sentence),
          former.empty() ? "" : fmt::format(" Formerly `{}`, which is still understood.", former));
    }
  }
  return page;
}

std::string configuration_schema(const Vocabulary& vocabulary) {
  static const Catalogue kNone;
  Row schema;
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  schema["title"] = "cvrbench configuration";
  schema["description"] =
      "Made by `cvrbench list config --json`, for editors; the program checks more (names of "
      "codecs, "
      "metrics and data sets).";
  schema.update(Row::parse(schema_of_map(infos_of(config_keys("", kNone, vocabulary)))));
  return schema.dump(1) + "\n";
}

}  // namespace cvr::experiments
