// The shared decoder text as C++: the very files that the shaders include, in the namespace cvr::shaders.
#pragma once

#include <bit>
#include <cstdint>

namespace cvr::shaders {

#include "shaders/shared/portable.glsl"

#include "shaders/shared/bit_vector.glsl"
#include "shaders/shared/morton.glsl"

#include "shaders/shared/csgvr.glsl"
#include "shaders/shared/csgvr_nibble.glsl"
#include "shaders/shared/neuroglancer.glsl"

}  // namespace cvr::shaders
