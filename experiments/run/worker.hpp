// The worker: the hidden command `cvrbench worker`. One process a cell, so that a crash, a hang or
// too little memory ends this process alone.
//
// Protocol, JSON lines: the first line of standard input is the WorkerSpec. The worker checks and
// answers
//   {"event": "ready", "parts": {...}}
// then each input line "round" is one timed round, answered by
//   {"event": "round", "samples": [[series, wall seconds, CPU seconds, count], ...]}
// and "stop" or the end of input ends it. What goes wrong is {"event": "failure", "status": ...,
// "reason": ...}, then the end.
#pragma once

#include <istream>

#include "experiments/stages/stage.hpp"

namespace cvr::experiments {

/// Answers go to the standard output that the process was started with; what libraries print there
/// joins standard error. Returns the exit code: 0 after stop, 1 after a failure event or when the
/// answers cannot be written.
int serve_worker(std::istream& in, StageHooks& hooks);

}  // namespace cvr::experiments
