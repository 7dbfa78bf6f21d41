// The file of noise floors, read for a machine that the seeds name.
#include "experiments/tracking/noise_floor.hpp"
#include "tests/fuzz/input_files.hpp"

CVR_FUZZ_TARGET(noise, input) {
  static const cvr::fuzz::InputFolder kFolder;
  const std::string path = kFolder.write("noise.json", input);
  for (const auto arrangement :
       {cvr::experiments::Arrangement::kApart, cvr::experiments::Arrangement::kInterleaved}) {
    try {
      cvr::experiments::load_floors(path, "m", arrangement).of("decode");
    } catch (const cvr::volumes::InputError&) {
    }
  }
}
