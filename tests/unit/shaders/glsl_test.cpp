// The decoder sources as GLSL: each, wrapped in a small kernel with the constants of a real encoding,
// compiles for Vulkan 1.3 and includes all that it needs; with the brick in device memory and,
// where the encoding has such a piece, in shared memory.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "codecs/container.hpp"
#include "codecs/registry.hpp"
#include "tests/samples/sample_volumes.hpp"

namespace cvr {
namespace {

using codecs::GpuEncoding;
namespace fs = std::filesystem;

constexpr std::string_view kPrelude = R"(#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 32) in;
#ifdef CVR_WORDS_SHARED
shared uint cvr_shared[CVR_SHARED_WORDS];
#endif
#include "shaders/shared/portable.glsl"
layout(push_constant) uniform Push {
  uint64_t buffers[6];
  Labels labels;
  uvec4 extent, grid;
} push;
#define CVR_BUFFER(i) Global(push.buffers[i])
#define CVR_BUFFER_AT(i, w) Global(push.buffers[i] + uint64_t(4) * (w))
uvec3 cvr_extent() { return push.extent.xyz; }
uvec3 cvr_grid() { return push.grid.xyz; }
bool cvr_code_visible(uint code) { return (code & 1u) == 0u; }
uint hops_counted = 0u;
)";

constexpr std::string_view kMain = R"(
void main() {
  uvec3 brick = gl_WorkGroupID;
  uint sum = cvr_decode_root(brick) + (cvr_decode_visible(brick, 0u) ? 1u : 0u);
#ifdef CVR_WORDS_SHARED
  Global source = cvr_shared_source(brick);
  for (uint i = gl_LocalInvocationIndex; i < cvr_shared_words(brick); i += 32u) cvr_shared[i] = cvr_read_global(source, i);
  barrier();
#endif
#ifdef TEST_CELLS
  sum += cvr_decode_cell(cvr_open_cells(brick, 1u), gl_GlobalInvocationID, 1u);
#endif
#ifdef TEST_BRICKS
  if (gl_LocalInvocationIndex == 0u) cvr_decode_brick(brick, 1u, push.labels);
#endif
  cvr_store(push.labels, gl_LocalInvocationIndex, sum + hops_counted);
}
)";

std::string kernel(const GpuEncoding& encoding, bool shared, bool count) {
  std::ostringstream text;
  std::string_view prelude = kPrelude;
  const auto first_line = prelude.find('\n') + 1;
  text << prelude.substr(0, first_line);
  if (shared)
    text << "#define CVR_WORDS_SHARED\n#define CVR_SHARED_WORDS " << encoding.shared_words << '\n';
  text << prelude.substr(first_line);
  text << "#define CVR_LEVELS " << encoding.levels << "\n#define CVR_BRICK_SHIFT "
       << encoding.levels - 1 << '\n';
  for (const auto& [name, value] : encoding.constants)
    text << "#define " << name << ' ' << value << '\n';
  text << "#define CVR_COUNT_HOPS(n)" << (count ? " hops_counted += (n)" : "") << '\n';
  text << "#include \"shaders/decode/" << encoding.decoder << ".glsl\"\n";
  if (encoding.voxel_access) text << "#define TEST_CELLS\n";
  if (encoding.serial) text << "#define TEST_BRICKS\n";
  text << kMain;
  return text.str();
}

/// Compiles in a folder of its own; the compiler's words, empty if it had nothing to say against
/// the text.
class Compiler {
 public:
  Compiler() : folder_(fs::temp_directory_path() / fmt::format("decode_texts_{}", getpid())) {
    fs::create_directories(folder_);
  }
  ~Compiler() { fs::remove_all(folder_); }
  std::string errors(const std::string& text) {
    const fs::path source = folder_ / "kernel.comp", log = folder_ / "log";
    std::ofstream(source) << text;
    const std::string command = fmt::format(
        "'{}' --target-env vulkan1.3 '-I{}' -o '{}' '{}' > '{}' 2>&1", CVR_GLSLANG, CVR_SOURCE_DIR,
        (folder_ / "kernel.spv").string(), source.string(), log.string());
    if (std::system(command.c_str()) == 0) return {};
    std::ostringstream words;
    words << "glslangValidator refuses the kernel:\n" << std::ifstream(log).rdbuf();
    return words.str();
  }

 private:
  fs::path folder_;
};

void expect_compiles(Compiler& compiler, const std::string& name, const GpuEncoding& encoding) {
  for (const bool shared : {false, true}) {
    if (shared && encoding.shared_words == 0) continue;
    for (const bool count : {false, true}) {
      EXPECT_EQ(compiler.errors(kernel(encoding, shared, count)), "")
          << name << (shared ? ", in shared memory" : "");
    }
  }
}

TEST(DecodeTextsAsGlsl, CompileWithTheConstantsOfEveryCodec) {
  Compiler compiler;
  std::set<std::string> seen;
  for (const codecs::Codec* codec : codecs::all_codecs()) {
    if (!codec->traits().gpu_decodable) continue;
    for (const std::string sample :
         {"blobs_u8", "blobs_u16", "blobs_u32", "blobs_u64", "one_label_2pow64_minus_1_u64"}) {
      const volumes::Volume volume = samples::sample(sample).volume();
      for (const codecs::Parameters& parameters : samples::parameter_corners(*codec)) {
        const auto encoded = codecs::encode(*codec, volumes::MemorySource(volume), parameters, 1);
        ASSERT_TRUE(encoded);
        const auto file = codecs::open_file(encoded->bytes.bytes());
        ASSERT_TRUE(file);
        const auto encoding = (*codecs::open_decoder(*file))->gpu_encoding(0, 1);
        ASSERT_TRUE(encoding) << encoding.error().message;
        // Each set of constants once.
        std::string constants = encoding->decoder + std::to_string(encoding->levels);
        for (const auto& [name, value] : encoding->constants)
          constants += fmt::format(" {}={}", name, value);
        if (!seen.insert(constants).second) continue;
        expect_compiles(compiler, fmt::format("{} ({})", codec->traits().id, constants), *encoding);
        if (HasFailure()) return;
      }
    }
  }
  EXPECT_GE(seen.size(), 10u);
}

TEST(DecodeTextsAsGlsl, AMistakeIsNoticed) {
  Compiler compiler;
  GpuEncoding encoding{.decoder = "csgvr_nibble", .levels = 6, .voxel_access = true};
  EXPECT_EQ(compiler.errors(kernel(encoding, false, false)), "");
  EXPECT_NE(compiler.errors(kernel(encoding, false, false) +
                            "uint unfinished() { return CVR_NO_SUCH_NAME; }\n"),
            "");
}

}  // namespace
}  // namespace cvr
