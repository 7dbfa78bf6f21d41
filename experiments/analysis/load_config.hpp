// A configuration as commands use it: read, and its tables and claims held to the metrics that
// there are and the cells that it has.
#pragma once

#include <string>
#include <vector>

#include "experiments/config/config.hpp"

namespace cvr::experiments {

/// read_config with all metrics, and check_claims. Throws InputError.
Config load_config(const std::string& path, const Catalogue& catalogue,
                   const std::vector<std::string>& settings);

}  // namespace cvr::experiments
