// cvrbench.
#include "experiments/cli/program.hpp"

int main(int argc, char** argv) {
  cvr::experiments::StageHooks hooks;
  return cvr::experiments::cli::run_program(argc, argv, hooks);
}
