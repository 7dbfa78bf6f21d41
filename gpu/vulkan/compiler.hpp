// GLSL to SPIR-V, by the glslang library.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cvr::gpu {

using Definitions = std::vector<std::pair<std::string, std::string>>;

/// A compute kernel: the definitions, then an #include of each file in its order. Each file includes
/// what it needs besides by its path from the source folder.
struct KernelSource {
  std::string name;  ///< for messages and time tables
  Definitions definitions;
  std::vector<std::string> files;  ///< paths as in shader_sources()
};

/// Appends definitions and files.
void append_source(KernelSource& source, const KernelSource& more);

/// Throws std::logic_error with the compiler's messages: a kernel that does not compile is a fault of
/// this program.
std::vector<std::uint32_t> compile_kernel(const KernelSource& source);

}  // namespace cvr::gpu
