// The shader sources, compiled into the program: it draws wherever it is installed.
#pragma once

#include <span>
#include <string_view>

namespace cvr::gpu {

struct ShaderSource {
  std::string_view path;  ///< from the source folder, for instance "shaders/shared/morton.glsl"
  std::string_view text;
};

std::span<const ShaderSource> shader_sources();

}  // namespace cvr::gpu
