// ASTC by astcenc: blocks of 3x3x3 to 6x6x6 voxels, 128 bits each.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& astc_codec();

}  // namespace cvr::codecs
