// BC4: slices in blocks of 4x4 texels at 4 bits each, a format that graphics hardware samples.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& bc4_codec();

}  // namespace cvr::codecs
