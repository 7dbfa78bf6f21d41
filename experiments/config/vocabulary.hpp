// The names that configurations use and that are defined above them: metrics (analysis/) and stages
// (stages/). Both are handed down to read_config().
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "experiments/config/metric_names.hpp"

namespace cvr::experiments {

/// What a configuration and its cells must know of a stage; stages/stage_kind.hpp has what it does.
struct StageTraits {
  std::string_view id;        ///< "random-access"
  std::string_view sentence;  ///< what it measures
  /// Counts changes of what it measures: rows of other versions are not the same cell.
  int version = 1;
  /// Its cells have the options of render_options.hpp; their threads prepare the image alone.
  bool renders = false;
  bool memcpy = false;  ///< measured of memcpy too, the speed of light of this machine
};

using StageList = std::span<const StageTraits* const>;
/// nullptr where no stage has this id.
const StageTraits* find_stage(StageList stages, std::string_view id);

struct Vocabulary {
  MetricNames metrics;
  StageList stages;
};

}  // namespace cvr::experiments
