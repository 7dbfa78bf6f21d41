// A machine's file in the store of figures over commits.
#include "experiments/tracking/history.hpp"

#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(history, input) {
  static const cvr::fuzz::InputFolder kFolder;
  kFolder.write("store/m.jsonl", input);
  try {
    cvr::experiments::read_history((kFolder.path() / "store").string(), "",
                                   (kFolder.path() / "noise.json").string());
  } catch (const cvr::volumes::InputError&) {
  }
}
