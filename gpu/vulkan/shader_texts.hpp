// The shader texts, compiled into the program: it draws wherever it is installed.
#pragma once

#include <span>
#include <string_view>

namespace cvr::gpu {

struct ShaderText {
  std::string_view path;  ///< from the source folder, for instance "shaders/shared/morton.glsl"
  std::string_view text;
};

std::span<const ShaderText> shader_texts();

}  // namespace cvr::gpu
