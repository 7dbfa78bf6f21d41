// A configuration: what is measured, how long, and which tables are made of it. docs/config.md lists
// the keys.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/config/block.hpp"
#include "experiments/config/cells.hpp"
#include "experiments/config/claim_spec.hpp"
#include "experiments/config/datasets.hpp"
#include "experiments/config/keys.hpp"
#include "experiments/config/table_spec.hpp"
#include "experiments/config/vocabulary.hpp"

namespace cvr::experiments {

struct Config {
  std::string path, hash, title;
  std::optional<double> scale;
  std::uint64_t rounds = 9, max_rounds = 0, rounds_per_process = UINT64_MAX;
  double target_interval = 0.05;
  double timeout_s = 120;
  double memory_limit_gib = 16;
  std::uint64_t together = UINT64_MAX;
  std::uint64_t seed = 1;
  std::vector<unsigned> lods;  ///< empty: all
  std::string device;          ///< of the stage render; empty: the renderer's choice
  std::vector<Cell> cells;     ///< see cells_of()
  std::vector<TableSpec> tables;
  std::vector<ClaimSpec> claims;
};

/// The keys with simple values, which --set may name.
std::vector<Key<Config>> simple_keys();

/// A configuration as it is read: its blocks become cells once all settings are known.
struct ConfigDraft {
  Config config;
  std::vector<Block> blocks;
};
/// What is handed over outlives the keys.
std::vector<Key<ConfigDraft>> config_keys(const std::string& path, const Catalogue& catalogue,
                                          const Vocabulary& vocabulary);

/// Reads a configuration; `settings` win over the file. They are "key=value" for its top-level keys
/// with simple values, for keys of blocks (then in every block that may have the key), and for paths
/// (settings.hpp). Throws InputError.
Config read_config(const std::string& path, const Catalogue& catalogue,
                   const std::vector<std::string>& settings, const Vocabulary& vocabulary);

/// Another device in place of the one that the configuration names.
void choose_device(Config& config, const std::string& device);

}  // namespace cvr::experiments
