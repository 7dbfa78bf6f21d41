// A NIfTI file: as it is, and gzipped with the right checksum. An input that is a gzip stream
// already is read as one.
#include "tests/fuzz/input_files.hpp"
#include "volumes/io/gzip.hpp"

CVR_FUZZ_TARGET(nifti, input) {
  static const cvr::fuzz::InputFolder kFolder;
  if (cvr::volumes::is_gzip(input)) {
    cvr::fuzz::exercise_volume(kFolder.write("v.nii.gz", input));
    return;
  }
  cvr::fuzz::exercise_volume(kFolder.write("v.nii", input));
  std::string packed;
  cvr::volumes::GzipWriter writer(
      [&](std::span<const std::byte> piece) { packed += cvr::fuzz::text_of(piece); }, 1);
  writer.write(input);
  writer.finish();
  cvr::fuzz::exercise_volume(kFolder.write("v.nii.gz", packed));
}
