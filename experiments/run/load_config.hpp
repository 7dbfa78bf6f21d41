// A configuration as commands use it: read, and its tables and claims held to the metrics and stages
// that there are and the cells that it has.
#pragma once

#include <string>
#include <vector>

#include "experiments/config/config.hpp"

namespace cvr::experiments {

/// All metrics and stages of this build.
Vocabulary vocabulary();

/// read_config with the vocabulary, and check_claims. Throws InputError.
Config load_config(const std::string& path, const Catalogue& catalogue,
                   const std::vector<std::string>& settings);

}  // namespace cvr::experiments
