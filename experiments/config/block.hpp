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
};

struct Block {
  std::vector<std::shared_ptr<const Dataset>> datasets;
  std::vector<CodecChoice> codecs;
  std::vector<const StageTraits*> stages;
  std::vector<Threads> threads{{"1", 1}};
  RenderBlock render;
};

/// What the reading of a block needs beside it; all outlive the keys.
struct BlockContext {
  const Catalogue& catalogue;
  StageList stages;
  std::string config_path;  ///< what paths of scenes are relative to
};
std::vector<Key<Block>> block_keys(const BlockContext& context);
/// The same, and whether the keys go together. Throws InputError.
Block read_block(const YamlValue& value, const BlockContext& context);

/// The cells of all blocks, each once: memcpy first for each data set, stage and number of threads
/// where the stage measures it. `scale` wins over the data sets' own. Throws InputError where there
/// are too many.
std::vector<Cell> cells_of(const std::vector<Block>& blocks, std::optional<double> scale,
                           const std::string& device, const std::string& config_path);

}  // namespace cvr::experiments
