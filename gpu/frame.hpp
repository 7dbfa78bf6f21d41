// The uniform block of all kernels: shaders/render/frame_fields.glsl as a C++ struct.
#pragma once

#include <cstdint>

#include "shaders/render/counters.glsl"

namespace cvr::gpu {

using uint = std::uint32_t;
using std::int64_t;
using std::uint64_t;

struct FrameConstants {
#include "shaders/render/frame_fields.glsl"
};

}  // namespace cvr::gpu
