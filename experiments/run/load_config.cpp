#include "experiments/run/load_config.hpp"

#include "experiments/analysis/claims.hpp"
#include "experiments/analysis/metrics.hpp"
#include "experiments/stages/stage_kind.hpp"

namespace cvr::experiments {

Vocabulary vocabulary() { return {metric_names(), stage_traits()}; }

Config load_config(const std::string& path, const Catalogue& catalogue,
                   const std::vector<std::string>& settings) {
  Config config = read_config(path, catalogue, settings, vocabulary());
  check_claims(config);
  return config;
}

}  // namespace cvr::experiments
