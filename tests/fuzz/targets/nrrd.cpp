// An attached NRRD file, header and voxels.
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(nrrd, input) {
  static const cvr::fuzz::InputFolder kFolder;
  cvr::fuzz::exercise_volume(kFolder.write("v.nrrd", input));
}
