// A chunk file of a precomputed folder. The first byte chooses encoding and voxel type.
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(precomputed_chunk, input) {
  if (input.empty()) return;
  static const cvr::fuzz::InputFolder kFolder;
  const unsigned choice = std::to_integer<unsigned>(input[0]);
  const bool compressed = choice % 2 == 0;
  const char* kTypes[] = {"uint32", "uint64", "uint8", "uint16"};
  const char* type = kTypes[choice / 2 % (compressed ? 2 : 4)];
  kFolder.write(
      "info",
      std::string(
          R"({"@type": "neuroglancer_multiscale_volume", "type": "segmentation", "num_channels": 1, "data_type": ")") +
          type +
          R"(", "scales": [{"key": "s", "size": [5, 6, 7], "resolution": [4, 4, 40], "voxel_offset": [0, 0, 0],)" +
          R"( "chunk_sizes": [[8, 8, 8]], "encoding": ")" +
          (compressed
               ? R"(compressed_segmentation", "compressed_segmentation_block_size": [4, 4, 4])"
               : R"(raw")") +
          "}]}");
  kFolder.write("s/0-5_0-6_0-7", input.subspan(1));
  cvr::fuzz::exercise_volume(kFolder.path().string());
}
