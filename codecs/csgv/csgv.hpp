// The serial CSGV codecs: strong rates, access by brick. See FORMAT.md in this folder.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& csgv_nibble_codec();
const Codec& csgv_rans_codec();

}  // namespace cvr::codecs
