// From the stream of one brick back to its labels.
#pragma once

#include <cstdint>
#include <span>

#include "codecs/csgv/brick_reader.hpp"
#include "codecs/csgv_ctx/model.hpp"

namespace cvr::codecs::csgv_ctx {

/// Rebuilds the levels 0..target of workspace.grid (of a constant brick the target alone).
/// `palette`: the labels of the brick, the root's first; `stream` may hold any bytes. `tally`
/// counts the symbols, or is nullptr. What is wrong, or nullptr.
csgv::BrickError rebuild_brick(const ContextModel& model, std::span<const std::uint32_t> palette,
                               std::span<const std::uint8_t> stream, const csgv::Validity& validity,
                               unsigned target, csgv::BrickWorkspace& workspace,
                               csgv::SymbolTally* tally);

}  // namespace cvr::codecs::csgv_ctx
