// The GPU facet of the CSGV families: start table and bricks as they lie in the payload, and what
// the format adds.
#pragma once

#include "codecs/csgv/brick_format.hpp"

namespace cvr::codecs::csgv {

/// See Decoder::gpu_encoding.
Expected<GpuEncoding> gpu_encoding(const BrickLayout& layout, std::span<const std::uint64_t> remap,
                                   const BrickFormat& format, std::uint32_t brick,
                                   unsigned threads);

}  // namespace cvr::codecs::csgv
