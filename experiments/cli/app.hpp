// The command line. Results go to standard output, progress and errors to standard error.
//
// Exit codes: 0 ok; 1 a check or a regression failed, every cell failed, or nothing could be
// judged; 2 usage, configuration or input; 3 the environment: nothing was measured because data or
// a device is missing, no process, no disk, no memory.
#pragma once

#include <string>

namespace cvr::experiments {
class StageHooks;
}

namespace cvr::experiments::cli {

struct Environment {
  std::string program;          ///< path of this program, for worker processes
  std::string data;             ///< the folder that ${CVRBENCH_DATA} stands for; may be empty
  std::string cache;            ///< folder for raw copies of data sets
  std::string share;            ///< folder for noise floors and history
  StageHooks* hooks = nullptr;  ///< of the worker
};

int run_command_line(int argc, char** argv, const Environment& environment);

}  // namespace cvr::experiments::cli
