// An encoded file. The envelope's checksums are made right, so that every byte reaches its codec.
#include "tests/fuzz/envelope.hpp"
#include "tests/fuzz/exercise.hpp"
#include "tests/fuzz/target.hpp"

CVR_FUZZ_TARGET(decode, input) {
  std::vector<std::byte> file(input.begin(), input.end());
  cvr::fuzz::repair_envelope(file);
  cvr::fuzz::exercise_file(file);
}
