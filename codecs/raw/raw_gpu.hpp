// The GPU facet of raw voxels: the volume and the coarser levels of its label pyramid in one buffer.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs::raw {

/// See Decoder::gpu_encoding. Labels of u64 that all fit in 32 bits are stored as u32.
Expected<GpuEncoding> gpu_encoding(const VolumeInfo& info, const std::byte* voxels, std::uint32_t brick, unsigned threads);

}  // namespace cvr::codecs::raw
