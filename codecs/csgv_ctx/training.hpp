// Fits the tables of a volume to what was counted of it: grows context trees by description length,
// then makes few distributions of their many leaves. All arithmetic is on integers: every build
// makes the same bytes.
#pragma once

#include <array>
#include <cstdint>

#include "codecs/csgv_ctx/events.hpp"
#include "codecs/csgv_ctx/model.hpp"

namespace cvr::codecs::csgv_ctx {

/// How often each width of a number occurs.
using NumberCounts = std::array<std::array<std::uint64_t, kSymbols>, kNumberKinds>;

/// The bits of a context that trees may ask for.
struct ContextBits {
  std::uint32_t statics = (1u << kStaticBits) - 1, dynamics = (1u << kDynamicBits) - 1;
};

ContextModel train(const EventCounts& events, const NumberCounts& numbers, const ContextBits& bits);

}  // namespace cvr::codecs::csgv_ctx
