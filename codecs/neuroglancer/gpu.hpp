// The GPU facet of compressed_segmentation: stored levels as they lie in the payload, and the
// coarser ones that a brick needs, encoded on the way.
#pragma once

#include "codecs/neuroglancer/format.hpp"

namespace cvr::codecs::neuroglancer {

struct StoredLevel {
  Extent extent;
  Extent grid;  ///< chunks
  std::span<const volumes::CompressedSegmentation>
      chunks;  ///< all in one piece of memory, in order
};

/// See Decoder::gpu_encoding. `decoder` gives the labels of the stored levels, whose chunks have
/// `edge` voxels per side.
Expected<GpuEncoding> gpu_encoding(const Decoder& decoder, const VolumeInfo& info,
                                   const volumes::BlockSize& block, std::uint32_t edge,
                                   std::span<const StoredLevel> stored, std::uint32_t brick,
                                   unsigned threads);

}  // namespace cvr::codecs::neuroglancer
