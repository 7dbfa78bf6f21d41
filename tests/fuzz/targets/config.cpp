// A configuration, over the catalogue of configs/datasets.
#include "experiments/run/load_config.hpp"
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(config, input) {
  static const cvr::fuzz::InputFolder kFolder;
  static const auto kCatalogue =
      cvr::experiments::Catalogue::from_folder(CVR_SOURCE_DIR "/configs/datasets");
  const std::string path = kFolder.write("configs/c.yaml", input);
  try {
    cvr::experiments::load_config(path, kCatalogue, {});
  } catch (const cvr::volumes::InputError&) {
  }
}
