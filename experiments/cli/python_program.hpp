// The programs of plots/, which commands run by a Python that has what they need.
#pragma once

#include <string>
#include <vector>

#include "experiments/cli/interruption.hpp"

namespace cvr::experiments::cli {

struct PythonProgram {
  std::string file;                  ///< in plots/
  std::vector<std::string> modules;  ///< beyond Python's own that it needs
};

/// What the report needs.
inline const std::vector<std::string> kReportModules{"matplotlib", "jinja2", "PIL"};

/// The path of this program for children, to which /proc/self/exe would be themselves.
std::string path_for_children(const std::string& program);

/// Runs it and waits. The exit code, kExitEnvironment for one that is none of this program's.
/// Throws EnvironmentError where the file is not there, or no Python with its modules.
int run_python(const PythonProgram& program, const std::vector<std::string>& arguments,
               InterruptWatch& watch);

}  // namespace cvr::experiments::cli
