// The random-access codecs CSGV-R: single voxels at any level of detail without decoding their
// brick. See FORMAT.md.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& csgvr_nibble_codec();
const Codec& csgvr_codec();
const Codec& csgvr_sb_codec();
const Codec& csgvr_c_codec();

}  // namespace cvr::codecs
