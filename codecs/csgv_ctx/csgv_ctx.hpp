// `csgv-ctx`: context-coded CSGV, a codec of this project for small bricks. See FORMAT.md in this
// folder.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& csgv_ctx_codec();

}  // namespace cvr::codecs
