// The GPU facet of the CSGV families: start table and bricks as they lie in the payload, and what
// the format adds.
#pragma once

#include "codecs/csgv/brick_reader.hpp"

namespace cvr::codecs::csgv {

/// See Decoder::gpu_encoding.
Expected<GpuEncoding> gpu_encoding(const BrickLayout& layout, std::span<const std::uint64_t> remap,
                                   const BrickReader& reader, std::uint32_t brick,
                                   unsigned threads);

/// What the published formats tell a GPU of their bricks, each a group of its own that ends with a
/// palette: all labels, and the words of the largest brick without its palette. Checks every
/// palette, which formats without voxel access leave unchecked on opening.
Expected<void> add_palettes(const BrickLayout& layout, unsigned threads, GpuEncoding& encoding);

}  // namespace cvr::codecs::csgv
