// What a GPU needs of the tables of `csgv-ctx` (shaders/shared/csgv_ctx.glsl reads them).
#pragma once

#include <cstdint>
#include <span>

#include "codecs/csgv_ctx/model.hpp"
#include "codecs/gpu_encoding.hpp"

namespace cvr::codecs::csgv_ctx {

/// Names text and constants, and adds the codes and the buffers "labels" (of the volume, ascending)
/// and "tables". group: bricks per side of a group; label_bits: of the place of a label among all.
void describe_tables(const ContextModel& model, std::span<const std::uint32_t> labels,
                     std::uint32_t group, unsigned label_bits, GpuEncoding& encoding);

}  // namespace cvr::codecs::csgv_ctx
