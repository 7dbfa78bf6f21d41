// A file of data set descriptions, and where the voxels of each are.
#include "experiments/config/datasets.hpp"
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(catalogue, input) {
  static const cvr::fuzz::InputFolder kFolder;
  const std::string path = kFolder.write("d.yaml", input);
  try {
    cvr::experiments::Catalogue catalogue;
    catalogue.add_file(path);
    for (const auto& dataset : catalogue.all()) dataset.generated_extent();
  } catch (const cvr::volumes::InputError&) {
  }
}
