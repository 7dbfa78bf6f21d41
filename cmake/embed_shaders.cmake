# Writes OUTPUT: a C++ table of all shader sources below SOURCE/shaders, by their path from SOURCE. Run as
#   cmake -DSOURCE=... -DOUTPUT=... -P embed_shaders.cmake
file(GLOB_RECURSE paths RELATIVE ${SOURCE} ${SOURCE}/shaders/*.glsl ${SOURCE}/shaders/*.comp)
list(SORT paths)
set(text "// Made by cmake/embed_shaders.cmake.\n#include \"gpu/vulkan/shader_sources.hpp\"\n\nnamespace cvr::gpu {\n\nstd::span<const ShaderSource> shader_sources() {\n  static constexpr ShaderSource kSources[] = {\n")
foreach(path ${paths})
  file(READ ${SOURCE}/${path} content)
  string(APPEND text "{\"${path}\", R\"cvr_glsl(${content})cvr_glsl\"},\n")
endforeach()
string(APPEND text "  };\n  return kSources;\n}\n\n}  // namespace cvr::gpu\n")
file(WRITE ${OUTPUT} "${text}")
