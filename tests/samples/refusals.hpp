// What codecs refuse of the sample volumes, and the list of it under version control
// (tests/golden/refusals.txt). Tests that walk the registry leave refused cases out; by this list a
// codec that begins to refuse fails them instead of making them smaller.
//
// A line: codec, parameters that differ from the defaults or "any", sample volume or "any", error
// code. "any" stands for all parameters where the codec takes no such volume, and for all volumes
// where the parameters do not go together.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "codecs/codec.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr::samples {

/// "bad-argument", "unsupported" and so on.
std::string_view name_of(volumes::ErrorCode code);

/// "csgvr brick=64 blobs_u8": a case without its error code; empty parameters: "any".
std::string refusal_case(const codecs::Codec& codec, const codecs::Parameters& parameters,
                         const SampleVolume& sample);

/// The lines of one codec, found by encoding every sample volume with every corner.
std::vector<std::string> find_refusals(const codecs::Codec& codec);

/// Whether the list under version control has the case, with whatever code. `file` is read once.
bool is_listed_refusal(const std::string& file, const codecs::Codec& codec,
                       const codecs::Parameters& parameters, const SampleVolume& sample);

}  // namespace cvr::samples
