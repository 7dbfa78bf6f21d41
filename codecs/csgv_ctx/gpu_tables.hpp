// What a GPU needs of the tables of `csgv-ctx` (shaders/decode/csgv_ctx.glsl reads them).
#pragma once

#include <cstdint>
#include <span>

#include "codecs/csgv_ctx/model.hpp"
#include "codecs/gpu_encoding.hpp"

namespace cvr::codecs::csgv_ctx {

/// Names text and constants, and adds the buffers "labels" (of the volume, ascending) and "tables".
void describe_tables(const ContextModel& model, std::span<const std::uint32_t> labels, unsigned label_bits, GpuEncoding& encoding);

}  // namespace cvr::codecs::csgv_ctx
