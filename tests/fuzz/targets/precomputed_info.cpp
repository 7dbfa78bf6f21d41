// The file `info` of a precomputed folder with three scales: s (raw chunks of 64 bytes), c
// (compressed_segmentation) and e (empty).
#include "tests/fuzz/input_files.hpp"

namespace {

const cvr::fuzz::InputFolder& folder_with_chunks() {
  static const cvr::fuzz::InputFolder kFolder;
  [[maybe_unused]] static const bool kWritten = [] {
    for (const char* name : {"s/0-4_0-4_0-4", "s/4-8_0-4_0-4"})
      kFolder.write(name, std::string(64, '\1'));
    // One channel at word 1, one block whose table begins at its word 2 and whose voxels take no
    // bits.
    const char compressed[] = {1, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 7, 0, 0, 0};
    kFolder.write("c/0-4_0-4_0-4", std::string_view(compressed, sizeof compressed));
    std::filesystem::create_directories(kFolder.path() / "e");
    return true;
  }();
  return kFolder;
}

}  // namespace

CVR_FUZZ_TARGET(precomputed_info, input) {
  const cvr::fuzz::InputFolder& folder = folder_with_chunks();
  folder.write("info", input);
  cvr::fuzz::exercise_volume(folder.path().string());
  cvr::fuzz::exercise_volume((folder.path() / "c").string());
}
