// A build against itself: how far its times lie apart though nothing has changed.
#pragma once

#include <utility>
#include <vector>

#include "experiments/tracking/comparison.hpp"

namespace cvr::experiments {

/// Two measurements of one build.
using Repeat = std::pair<std::vector<Result>, std::vector<Result>>;

/// By kind of time, over all cells of all repeats but those of memcpy: `floor`, twice the largest
/// gap between quartile ranges, at least 5 % (paired) or 10 %; `cells`, and `median` and `largest`
/// of |ratio - 1|. For store_floors(). `paired`: the rounds of each repeat were interleaved.
Row measure_floors(const std::vector<Repeat>& repeats, bool paired);

}  // namespace cvr::experiments
