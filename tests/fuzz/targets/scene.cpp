// A scene file.
#include "experiments/config/scene_file.hpp"
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(scene, input) {
  static const cvr::fuzz::InputFolder kFolder;
  const std::string path = kFolder.write("s.yaml", input);
  try {
    cvr::experiments::load_scene(path);
  } catch (const cvr::volumes::InputError&) {
  }
}
