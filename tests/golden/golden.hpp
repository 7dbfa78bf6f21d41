// The golden encodings: tiny fixed volumes, and the bytes that every codec made of them when its
// format was fixed.
//
// tests/golden/data/CODEC_PARAMETERS.VOLUME.cvr, each a few KB, is compared with what the encoder
// writes now and decoded by what the decoder reads now. A difference is a change of format: it
// needs a new version of the codec. To write the files anew (the sources of general-purpose
// compressors' bytes are Debian 12's libraries; another release may write others):
//
//   CVRBENCH_WRITE_GOLDEN=1 build/bin/test_golden
//
// Parameters: the defaults, except that a parameter with a list of choices takes its first, which
// keeps the files small.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "codecs/container.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::golden {

struct GoldenVolume {
  samples::SampleVolume sample;
  std::uint64_t hash;  ///< XXH3-64 of the voxels: checked before any stream is
};

const std::vector<GoldenVolume>& golden_volumes();
/// Four time steps; for codecs that know of time, which have the parameter `books`.
const GoldenVolume& golden_series();
bool knows_time(const codecs::Codec& codec);
/// Small choices, then what `assignments` say.
codecs::Parameters golden_parameters(const codecs::Codec& codec,
                                     const std::vector<std::string>& assignments = {});
std::string golden_path(const codecs::Codec& codec, const GoldenVolume& volume,
                        const codecs::Parameters& parameters);

}  // namespace cvr::golden
