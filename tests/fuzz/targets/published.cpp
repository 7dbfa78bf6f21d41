// A file of published figures.
#include "experiments/config/published.hpp"

#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(published, input) {
  static const cvr::fuzz::InputFolder kFolder;
  const std::string path = kFolder.write("published.yaml", input);
  try {
    cvr::experiments::load_published(path, "t");
  } catch (const cvr::volumes::InputError&) {
  }
}
