// Vector quantisation of blocks of 4x4x4 voxels: vq of whole blocks, hvq of a hierarchy of means
// (Schneider & Westermann 2003), tvq of transform coefficients with classified codebooks (Fout & Ma
// 2007).
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& vq_codec();
const Codec& hvq_codec();
const Codec& tvq_codec();

}  // namespace cvr::codecs
