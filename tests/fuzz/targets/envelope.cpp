// An encoded file as it is: what the envelope refuses before a codec is asked.
#include "tests/fuzz/exercise.hpp"
#include "tests/fuzz/target.hpp"

CVR_FUZZ_TARGET(envelope, input) { cvr::fuzz::exercise_file(input); }
