// The "frames" of a row of the render stage, from the samples of its rounds.
#pragma once

#include "experiments/row_building.hpp"

namespace cvr::experiments {

/// Milliseconds of the device. Each round is the camera path from an empty cache; the first also warms the machine up, so mean,
/// median and the high quantiles are those of the later rounds where there are any, and the first round's mean stands apart.
Row describe_frames(const Measured& measured);

}  // namespace cvr::experiments
