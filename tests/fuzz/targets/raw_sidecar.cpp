// The YAML beside raw voxels. The first byte is the number of voxel bytes, the rest the text.
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(raw_sidecar, input) {
  if (input.empty()) return;
  static const cvr::fuzz::InputFolder kFolder;
  const std::string path =
      kFolder.write("v.raw", std::string(std::to_integer<std::size_t>(input[0]), '\1'));
  kFolder.write("v.raw.yaml", input.subspan(1));
  cvr::fuzz::exercise_volume(path);
}
