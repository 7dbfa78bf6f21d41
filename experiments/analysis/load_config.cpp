#include "experiments/analysis/load_config.hpp"

#include "experiments/analysis/claims.hpp"
#include "experiments/analysis/metrics.hpp"

namespace cvr::experiments {

Config load_config(const std::string& path, const Catalogue& catalogue,
                   const std::vector<std::string>& settings) {
  Config config = read_config(path, catalogue, settings, metric_names());
  check_claims(config);
  return config;
}

}  // namespace cvr::experiments
