// A block of the matrix: data sets x codecs x stages x threads, and of the stage render its options.
// The cells of a configuration are the union of the products of its blocks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "experiments/config/cells.hpp"
#include "experiments/config/keys.hpp"
#include "experiments/config/render_options.hpp"

namespace cvr::experiments {

struct CodecChoice {
  const codecs::Codec* codec;
  codecs::Parameters parameters;
  std::vector<std::string> datasets;  ///< of the block that it is measured on; empty: all
  RenderBlock render;                 ///< in place of what the block says
};

struct Block {
  std::vector<std::shared_ptr<const Dataset>> datasets;
  std::vector<CodecChoice> codecs;
  std::vector<const StageTraits*> stages;
  std::vector<Threads> threads{{"1", 1}};
  RenderBlock render;
  /// What else holds for single data sets, by their names.
  std::vector<std::pair<std::string, RenderBlock>> per_dataset;

  /// Whether a codec is measured on a data set of the block.
  static bool goes_with(const CodecChoice& choice, const Dataset& dataset);
  /// What holds for both: the codec's own before the data set's before the block's.
  RenderBlock render_of(const Dataset& dataset, const CodecChoice& choice) const;
};

/// What the reading of a block needs beside it; all outlive the keys.
struct BlockContext {
  const Catalogue& catalogue;
  StageList stages;
  std::string config_path;  ///< what paths of scenes are relative to
};
std::vector<Key<Block>> block_keys(const BlockContext& context);
/// Of an entry of `codecs` that is a map.
std::vector<KeyInfo> codec_entry_keys(const BlockContext& context);
/// The same, and whether the keys go together. Throws InputError.
Block read_block(const YamlValue& value, const BlockContext& context);

/// The cells of all blocks, each once: memcpy first for each data set, stage and number of threads
/// where the stage measures it. `scale` wins over the data sets' own. Throws InputError where there
/// are too many.
std::vector<Cell> cells_of(const std::vector<Block>& blocks, std::optional<double> scale,
                           const std::string& device, const std::string& config_path);

}  // namespace cvr::experiments
