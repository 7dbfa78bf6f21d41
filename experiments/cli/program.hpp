// The program as a whole: what the environment tells, then the command line.
#pragma once

#include "experiments/stages/stage.hpp"

namespace cvr::experiments::cli {

/// The exit code. `hooks`: of the worker.
int run_program(int argc, char** argv, StageHooks& hooks);

}  // namespace cvr::experiments::cli
