// `@ID@`: runs of equal voxels. FORMAT.md has the bytes.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& @NAME@_codec();

}  // namespace cvr::codecs
