// zfp by libzfp: blocks of 4x4x4 voxels at a fixed rate or to a fixed accuracy.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& zfp_codec();

}  // namespace cvr::codecs
