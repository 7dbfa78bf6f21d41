#include "tests/samples/shared_decoders.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <string_view>

#include "shaders/shared/shared.hpp"

namespace cvr::shaders {

namespace {

struct uvec3 {
  uint x, y, z;
  uvec3(uint x_, uint y_, uint z_) : x(x_), y(y_), z(z_) {}
};
uvec3 operator>>(const uvec3& v, uint n) { return {v.x >> n, v.y >> n, v.z >> n}; }
uvec3 operator<<(const uvec3& v, uint n) { return {v.x << n, v.y << n, v.z << n}; }
uvec3 operator&(const uvec3& v, uint m) { return {v.x & m, v.y & m, v.z & m}; }
uvec3 operator/(const uvec3& v, uint n) { return {v.x / n, v.y / n, v.z / n}; }
uvec3 operator*(const uvec3& v, uint n) { return {v.x * n, v.y * n, v.z * n}; }
uvec3 operator-(const uvec3& a, const uvec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
uvec3 operator+(const uvec3& v, uint n) { return {v.x + n, v.y + n, v.z + n}; }
uvec3 min(const uvec3& a, const uvec3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}

/// What a kernel's constants and bindings say.
struct Bindings {
  const std::vector<std::vector<std::uint32_t>>* buffers = nullptr;
  const codecs::GpuEncoding* encoding = nullptr;
  uvec3 extent{0, 0, 0}, grid{0, 0, 0};
  const std::function<bool(std::uint32_t)>* shown = nullptr;

  Words buffer(unsigned i, uint64_t word) const { return {(*buffers)[i].data() + word}; }
  uint constant(std::string_view name) const {
    for (const auto& [key, value] : encoding->constants) {
      if (key == name) return value;
    }
    throw std::logic_error("a decoder text asks for a constant that its encoding does not have");
  }
};
thread_local Bindings bound;

uvec3 cvr_extent() { return bound.extent; }
uvec3 cvr_grid() { return bound.grid; }
bool cvr_code_visible(uint code) { return (*bound.shown)(code); }

#define CVR_BUFFER(i) bound.buffer(i, 0)
#define CVR_BUFFER_AT(i, word) bound.buffer(i, word)
#define CVR_COUNT_HOPS(n) static_cast<void>(n)
#define CVR_LEVELS bound.encoding->levels
#define CVR_BRICK_SHIFT (bound.encoding->levels - 1)
#define CVR_REMAP_SIZE bound.constant("CVR_REMAP_SIZE")

namespace raw_8 {
#define CVR_RAW_BITS 8
#include "shaders/decode/raw.glsl"
#undef CVR_RAW_BITS
}  // namespace raw_8
namespace raw_16 {
#define CVR_RAW_BITS 16
#include "shaders/decode/raw.glsl"
#undef CVR_RAW_BITS
}  // namespace raw_16
namespace raw_32 {
#define CVR_RAW_BITS 32
#include "shaders/decode/raw.glsl"
#undef CVR_RAW_BITS
}  // namespace raw_32
namespace raw_64 {
#define CVR_RAW_BITS 64
#include "shaders/decode/raw.glsl"
#undef CVR_RAW_BITS
}  // namespace raw_64

#define CVR_NEUROGLANCER_BLOCK_X bound.constant("CVR_NEUROGLANCER_BLOCK_X")
#define CVR_NEUROGLANCER_BLOCK_Y bound.constant("CVR_NEUROGLANCER_BLOCK_Y")
#define CVR_NEUROGLANCER_BLOCK_Z bound.constant("CVR_NEUROGLANCER_BLOCK_Z")
#define CVR_NEUROGLANCER_TABLE_WORDS bound.constant("CVR_NEUROGLANCER_TABLE_WORDS")
namespace neuroglancer {
#include "shaders/decode/neuroglancer.glsl"
}  // namespace neuroglancer

#define CVR_CSGV_DELTA bound.constant("CVR_CSGV_DELTA")
namespace csgv_nibble {
#define CVR_CSGV_RANS 0
#include "shaders/decode/csgv.glsl"
#undef CVR_SERIAL_NIBBLE
#undef CVR_CSGV_RANS
}  // namespace csgv_nibble
#undef CVR_SERIAL_STOP_BITS
#undef CVR_SERIAL_DELTA
namespace csgv_rans {
#define CVR_CSGV_RANS 1
#include "shaders/decode/csgv.glsl"
#undef CVR_SERIAL_RANS
#undef CVR_CSGV_RANS
}  // namespace csgv_rans
#undef CVR_SERIAL_STOP_BITS
#undef CVR_SERIAL_DELTA

#define CVR_CTX_GROUP_SHIFT bound.constant("CVR_CTX_GROUP_SHIFT")
#define CVR_CTX_LABEL_BITS bound.constant("CVR_CTX_LABEL_BITS")
#define CVR_CTX_ROWS_AT bound.constant("CVR_CTX_ROWS_AT")
#define CVR_CTX_SLOTS_AT bound.constant("CVR_CTX_SLOTS_AT")
#define CVR_CTX_SYMBOLS_AT bound.constant("CVR_CTX_SYMBOLS_AT")
#define CVR_CTX_NUMBERS bound.constant("CVR_CTX_NUMBERS")
namespace csgv_ctx {
#include "shaders/decode/csgv_ctx.glsl"
}  // namespace csgv_ctx

namespace csgvr {
#define CVR_CSGVR_STOP_BITS bound.constant("CVR_CSGVR_STOP_BITS")
#include "shaders/decode/csgvr.glsl"
#undef CVR_SERIAL_WAVELET
}  // namespace csgvr
#undef CVR_SERIAL_STOP_BITS
#undef CVR_SERIAL_DELTA
namespace csgvr_c {
#include "shaders/decode/csgvr_c.glsl"
#undef CVR_SERIAL_CSGVR_C
}  // namespace csgvr_c
namespace csgvr_nibble {
#include "shaders/decode/csgvr_nibble.glsl"
#undef CVR_SERIAL_CSGVR_NIBBLE
}  // namespace csgvr_nibble

/// The functions of one text.
struct Entry {
  uint (*root)(uvec3);
  bool (*visible)(uvec3, uint);
  uint (*cell)(uvec3, uint);
  void (*brick)(uvec3, uint, Labels);
};

#define CVR_ENTRY(name, cell, brick) \
  Entry { name::cvr_decode_root, name::cvr_decode_visible, cell, brick }
#define CVR_CELL_ENTRY(name, brick)                                                              \
  CVR_ENTRY(                                                                                     \
      name,                                                                                      \
      [](uvec3 cell, uint lod) {                                                                 \
        return name::cvr_decode_cell(name::cvr_open_cells(cell >> (CVR_BRICK_SHIFT - lod), lod), \
                                     cell, lod);                                                 \
      },                                                                                         \
      brick)

Entry entry_of(const Bindings& b) {
  const std::string_view name = b.encoding->decoder;
  if (name == "raw") {
    switch (b.constant("CVR_RAW_BITS")) {
      case 8:
        return CVR_CELL_ENTRY(raw_8, nullptr);
      case 16:
        return CVR_CELL_ENTRY(raw_16, nullptr);
      case 32:
        return CVR_CELL_ENTRY(raw_32, nullptr);
      default:
        return CVR_CELL_ENTRY(raw_64, nullptr);
    }
  }
  if (name == "neuroglancer") return CVR_CELL_ENTRY(neuroglancer, nullptr);
  if (name == "csgv") {
    return b.constant("CVR_CSGV_RANS") != 0
               ? CVR_ENTRY(csgv_rans, nullptr, csgv_rans::cvr_decode_brick)
               : CVR_ENTRY(csgv_nibble, nullptr, csgv_nibble::cvr_decode_brick);
  }
  if (name == "csgv_ctx") return CVR_ENTRY(csgv_ctx, nullptr, csgv_ctx::cvr_decode_brick);
  if (name == "csgvr") return CVR_CELL_ENTRY(csgvr, csgvr::cvr_decode_brick);
  if (name == "csgvr_c") return CVR_CELL_ENTRY(csgvr_c, csgvr_c::cvr_decode_brick);
  if (name == "csgvr_nibble") return CVR_CELL_ENTRY(csgvr_nibble, csgvr_nibble::cvr_decode_brick);
  throw std::logic_error("no such decoder text: " + std::string(name));
}

}  // namespace

}  // namespace cvr::shaders

namespace cvr::samples {

namespace {

using shaders::uvec3;

uvec3 narrow(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
          static_cast<std::uint32_t>(z)};
}
uvec3 narrow(const volumes::Coordinate& c) { return narrow(c.x, c.y, c.z); }

shaders::Entry bind(const codecs::GpuEncoding& encoding,
                    const std::vector<std::vector<std::uint32_t>>& buffers,
                    const volumes::Extent& extent, const volumes::Extent& grid) {
  shaders::bound = {&buffers, &encoding, narrow(extent.x, extent.y, extent.z),
                    narrow(grid.x, grid.y, grid.z), nullptr};
  return shaders::entry_of(shaders::bound);
}

}  // namespace

DecodeText::DecodeText(const codecs::GpuEncoding& encoding, const volumes::VolumeInfo& info)
    : encoding_(encoding),
      extent_(info.extent),
      grid_(volumes::ceil_div(info.extent, encoding.brick)),
      remap_(encoding.remap.begin(), encoding.remap.end()) {
  for (const codecs::GpuBuffer& buffer : encoding.buffers) {
    if (buffer.bytes.size() % 4 != 0) throw std::logic_error("a buffer is not made of whole words");
    std::vector<std::uint32_t> words(buffer.bytes.size() / 4);
    if (!words.empty()) std::memcpy(words.data(), buffer.bytes.data(), buffer.bytes.size());
    buffers_.push_back(std::move(words));
  }
  encoding_.buffers.clear();
  encoding_.remap = {};
}

std::uint32_t DecodeText::root(const volumes::Coordinate& brick) const {
  return bind(encoding_, buffers_, extent_, grid_).root(narrow(brick));
}

bool DecodeText::visible(const volumes::Coordinate& brick,
                         const std::function<bool(std::uint32_t)>& shown) const {
  const shaders::Entry entry = bind(encoding_, buffers_, extent_, grid_);
  shaders::bound.shown = &shown;
  for (std::uint32_t part = 0; part < encoding_.brick; ++part) {
    if (entry.visible(narrow(brick), part)) return true;
  }
  return false;
}

std::uint32_t DecodeText::cell(const volumes::Coordinate& cell, unsigned lod) const {
  return bind(encoding_, buffers_, extent_, grid_).cell(narrow(cell), lod);
}

std::vector<std::uint32_t> DecodeText::brick(const volumes::Coordinate& brick, unsigned lod) const {
  std::vector<std::uint32_t> codes(std::size_t{1} << (3 * (encoding_.levels - 1 - lod)));
  bind(encoding_, buffers_, extent_, grid_).brick(narrow(brick), lod, {codes.data()});
  return codes;
}

}  // namespace cvr::samples
