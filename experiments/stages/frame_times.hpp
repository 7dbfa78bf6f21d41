// The "frames" and the "held" of a row of the render stage, from the samples of its rounds.
// Milliseconds of the device; statistics are those of the rounds after the first, which also warms
// the machine up, where there are any.
#pragma once

#include "experiments/results/measured.hpp"

namespace cvr::experiments {

/// Each round is the camera path from an empty cache. The first round's mean stands apart, and so
/// do the first frames. None where no frame was drawn.
std::optional<Parts::Frames> describe_frames(const Measured& measured);

/// Adds the frames of one view with the cache filled; false where none were drawn.
bool add_held_frames(const Measured& measured, Parts::Held& held);

}  // namespace cvr::experiments
