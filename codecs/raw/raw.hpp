// `raw`: the voxels as they are. The reference of every table, and the plain array read of the
// random-access stage.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& raw_codec();

}  // namespace cvr::codecs
