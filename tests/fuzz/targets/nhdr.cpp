// A detached NRRD header beside data files of 64 bytes: raw, gzipped, and three of a series.
#include "tests/fuzz/input_files.hpp"
#include "volumes/io/gzip.hpp"

namespace {

const cvr::fuzz::InputFolder& folder_with_data() {
  static const cvr::fuzz::InputFolder kFolder;
  [[maybe_unused]] static const bool kWritten = [] {
    const std::string data(64, '\1');
    std::string packed;
    cvr::volumes::GzipWriter writer(
        [&](std::span<const std::byte> piece) { packed += cvr::fuzz::text_of(piece); }, 6);
    writer.write(std::as_bytes(std::span(data)));
    writer.finish();
    for (const char* name : {"v.raw", "v1.raw", "v2.raw", "v3.raw"}) kFolder.write(name, data);
    for (const char* name : {"v.raw.gz", "v1.raw.gz"}) kFolder.write(name, packed);
    return true;
  }();
  return kFolder;
}

}  // namespace

CVR_FUZZ_TARGET(nhdr, input) {
  cvr::fuzz::exercise_volume(folder_with_data().write("v.nhdr", input));
}
