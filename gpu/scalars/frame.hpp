// The uniform block of the kernels of scalars: shaders/scalars/frame_fields.glsl as a C++ struct.
#pragma once

#include <cstdint>

namespace cvr::gpu {

struct ScalarFrame {
  using uint = std::uint32_t;
  using uint64_t = std::uint64_t;
#include "shaders/scalars/frame_fields.glsl"
};

}  // namespace cvr::gpu
