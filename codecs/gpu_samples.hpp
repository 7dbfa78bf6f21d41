// What a GPU needs to decode single scalars of an opened stream: buffers, the name of a decoder
// source, and its constants.
//
// The renderer of scalars knows no codec by name: it uploads the buffers in their order, includes
// shaders/scalars/<decoder>.glsl and calls cvr_sample(voxel) (shaders/scalars/README.md).
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "codecs/gpu_encoding.hpp"

namespace cvr::codecs {

struct GpuSamples {
  std::string decoder;  ///< shaders/scalars/<decoder>.glsl
  std::vector<std::pair<std::string, std::uint32_t>>
      constants;                   ///< become #defines before the source
  std::vector<GpuBuffer> buffers;  ///< at most 6; the source reads the i-th as CVR_BUFFER(i)
};

}  // namespace cvr::codecs
