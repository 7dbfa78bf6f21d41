// Neuroglancer's compressed_segmentation as a codec: chunks of labels, each a public stream, each
// label four reads away.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& neuroglancer_codec();

}  // namespace cvr::codecs
