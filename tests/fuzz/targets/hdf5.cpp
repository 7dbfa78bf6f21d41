// An HDF5 file: the only data set, and the one that another reader of the same file would name.
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(hdf5, input) {
  static const cvr::fuzz::InputFolder kFolder;
  const std::string path = kFolder.write("v.h5", input);
  cvr::fuzz::exercise_volume(path);
  cvr::fuzz::exercise_volume(path + ":/volumes/labels",
                             {.kind = cvr::volumes::VolumeKind::kLabels, .axes = {}});
}
