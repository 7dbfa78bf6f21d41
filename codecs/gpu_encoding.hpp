// What a GPU needs to decode an opened stream: buffers, the name of a decoder source, and its
// constants.
//
// The renderer and its caches know no codec by name. They upload the buffers in their order,
// include shaders/decode/<decoder>.glsl and call the functions that shaders/decode/README.md lists.
// Inside shaders a label is a 32-bit *code*: the label itself, or an index into `remap` where
// labels do not fit in 32 bits.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "volumes/buffer.hpp"

namespace cvr::codecs {

/// One piece of device memory. The bytes are a multiple of 4 and live as long as the decoder, or
/// are owned here.
struct GpuBuffer {
  std::string use;  ///< one word for memory tables, for instance "bricks", "starts", "levels"
  std::span<const std::byte> bytes;
  std::shared_ptr<const volumes::Buffer>
      owned;  ///< what `bytes` views, if it was made for the upload
};

struct GpuEncoding {
  std::string decoder;  ///< shaders/decode/<decoder>.glsl
  std::vector<std::pair<std::string, std::uint32_t>>
      constants;                   ///< become #defines before the source
  std::vector<GpuBuffer> buffers;  ///< at most 6; the source reads the i-th as CVR_BUFFER(i)
  std::uint32_t brick = 0;         ///< voxels per side
  unsigned levels = 0;             ///< log2(brick) + 1
  bool voxel_access = false;       ///< the source decodes single cells
  bool serial = false;             ///< the source decodes whole bricks in one sweep
  bool together = false;           ///< ... and by the invocations of a subgroup
  /// Words that a subgroup would copy to shared memory for the largest brick; 0: the encoding has
  /// no such piece.
  std::uint32_t shared_words = 0;
  /// Iterations of loops, at most or nearly: of one cell, of one brick in one sweep. Some drivers
  /// bound them (gpu/vulkan/device.hpp).
  std::uint32_t cell_loops = 1, brick_loops = 0;
  std::vector<std::uint32_t> codes;      ///< every label code of the volume, ascending
  std::span<const std::uint64_t> remap;  ///< label of each code; empty: a code is the label
};

}  // namespace cvr::codecs
