// The shared decoder source as C++: the very files that the shaders include, in the namespace
// cvr::shaders.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

namespace cvr::shaders {

#include "shaders/shared/bit_vector.glsl"
#include "shaders/shared/brick_limits.glsl"
#include "shaders/shared/csgv_ctx.glsl"
#include "shaders/shared/csgvr.glsl"
#include "shaders/shared/csgvr_c.glsl"
#include "shaders/shared/csgvr_nibble.glsl"
#include "shaders/shared/cuckoo.glsl"
#include "shaders/shared/label_codes.glsl"
#include "shaders/shared/morton.glsl"
#include "shaders/shared/neuroglancer.glsl"
#include "shaders/shared/operations.glsl"
#include "shaders/shared/portable.glsl"
#include "shaders/shared/tvq.glsl"

// The serial decoder, once for each source of symbols.
namespace serial_nibble {
#define CVR_SERIAL_NIBBLE
#include "shaders/shared/csgv_serial.glsl"
#undef CVR_SERIAL_NIBBLE
}  // namespace serial_nibble
namespace serial_rans {
#define CVR_SERIAL_RANS
#include "shaders/shared/csgv_serial.glsl"
#undef CVR_SERIAL_RANS
}  // namespace serial_rans
namespace serial_csgvr_nibble {
#define CVR_SERIAL_CSGVR_NIBBLE
#include "shaders/shared/csgv_serial.glsl"
#undef CVR_SERIAL_CSGVR_NIBBLE
}  // namespace serial_csgvr_nibble
namespace serial_wavelet {
#define CVR_SERIAL_WAVELET
#include "shaders/shared/csgv_serial.glsl"
#undef CVR_SERIAL_WAVELET
}  // namespace serial_wavelet
namespace serial_csgvr_c {
#define CVR_SERIAL_CSGVR_C
#include "shaders/shared/csgv_serial.glsl"
#undef CVR_SERIAL_CSGVR_C
}  // namespace serial_csgvr_c

}  // namespace cvr::shaders
