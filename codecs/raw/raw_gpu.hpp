// The GPU facets of raw voxels: labels with the coarser levels of their pyramid in one buffer;
// scalars as they are.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs::raw {

/// See Decoder::gpu_encoding. Labels of u64 that all fit in 32 bits are stored as u32.
Expected<GpuEncoding> gpu_encoding(const VolumeInfo& info, const std::byte* voxels,
                                   std::uint32_t brick, unsigned threads);

/// See Decoder::gpu_samples.
Expected<GpuSamples> gpu_samples(const VolumeInfo& info, const std::byte* voxels);

}  // namespace cvr::codecs::raw
