// All codecs of this build. Adding one = one folder and one line in registry.cpp.
#pragma once

#include <span>
#include <string_view>

#include "codecs/codec.hpp"

namespace cvr::codecs {

/// In the order in which tables list them.
std::span<const Codec* const> all_codecs();
/// nullptr if there is none of that id.
const Codec* find_codec(std::string_view id);

}  // namespace cvr::codecs
