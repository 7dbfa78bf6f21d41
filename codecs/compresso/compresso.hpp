// Compresso: boundary bits in windows, one label for each connected component of each slice.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& compresso_codec();
/// The same payload inside an xz container.
const Codec& compresso_lzma_codec();

}  // namespace cvr::codecs
