#include "gpu/vulkan/compiler.hpp"

#include <fmt/format.h>
#include <glslang/Include/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <algorithm>
#include <stdexcept>

#include "gpu/vulkan/shader_sources.hpp"

namespace cvr::gpu {

namespace {

constexpr std::string_view kPrelude = R"(#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_memory_scope_semantics : require
)";

const ShaderSource* find_source(std::string_view path) {
  const auto sources = shader_sources();
  const auto found = std::ranges::find(sources, path, &ShaderSource::path);
  return found == sources.end() ? nullptr : &*found;
}

/// Includes name paths from the source folder.
class Includer final : public glslang::TShader::Includer {
 public:
  IncludeResult* includeLocal(const char* header, const char*, std::size_t) override {
    const ShaderSource* source = find_source(header);
    return source == nullptr
               ? nullptr
               : new IncludeResult(header, source->text.data(), source->text.size(), nullptr);
  }
  void releaseInclude(IncludeResult* result) override { delete result; }
};

struct Library {
  Library() { glslang::InitializeProcess(); }
  ~Library() { glslang::FinalizeProcess(); }
};

TBuiltInResource resources() {
  TBuiltInResource r{};
  r.maxComputeWorkGroupCountX = r.maxComputeWorkGroupCountY = r.maxComputeWorkGroupCountZ = 65535;
  r.maxComputeWorkGroupSizeX = r.maxComputeWorkGroupSizeY = 1024;
  r.maxComputeWorkGroupSizeZ = 64;
  r.limits = {true, true, true, true, true, true, true, true, true};
  return r;
}

}  // namespace

void append_source(KernelSource& source, const KernelSource& more) {
  source.definitions.insert(source.definitions.end(), more.definitions.begin(),
                            more.definitions.end());
  source.files.insert(source.files.end(), more.files.begin(), more.files.end());
}

std::vector<std::uint32_t> compile_kernel(const KernelSource& source) {
  static const Library kLibrary;
  std::string text(kPrelude);
  for (const auto& [name, value] : source.definitions)
    text += fmt::format("#define {} {}\n", name, value);
  for (const std::string& path : source.files) text += fmt::format("#include \"{}\"\n", path);
  const char* strings[] = {text.c_str()};
  const char* names[] = {source.name.c_str()};
  glslang::TShader shader(EShLangCompute);
  shader.setStringsWithLengthsAndNames(strings, nullptr, names, 1);
  shader.setEnvInput(glslang::EShSourceGlsl, EShLangCompute, glslang::EShClientVulkan, 100);
  shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_3);
  shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_6);
  const TBuiltInResource limits = resources();
  const auto messages = static_cast<EShMessages>(EShMsgSpvRules | EShMsgVulkanRules);
  Includer includer;
  if (!shader.parse(&limits, 460, ECoreProfile, false, true, messages, includer))
    throw std::logic_error(fmt::format("kernel {}: {}", source.name, shader.getInfoLog()));
  glslang::TProgram program;
  program.addShader(&shader);
  if (!program.link(messages))
    throw std::logic_error(fmt::format("kernel {}: {}", source.name, program.getInfoLog()));
  std::vector<std::uint32_t> words;
  glslang::SpvOptions options;
  options.disableOptimizer = true;
  glslang::GlslangToSpv(*program.getIntermediate(EShLangCompute), words, &options);
  return words;
}

}  // namespace cvr::gpu
