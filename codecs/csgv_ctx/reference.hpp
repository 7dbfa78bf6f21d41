// References to older palette entries, and how they are coded.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "codecs/csgv_ctx/model.hpp"

namespace cvr::codecs::csgv_ctx {

/// `entries` in use >= 2, the one meant 1 <= distance < entries before the newest.
struct Reference {
  std::uint32_t distance, entries;
};

/// How a reference is coded: by the width of distance - 1, then the bits below the highest one.
struct CodedReference {
  explicit CodedReference(const Reference& reference)
      : value(reference.distance - 1), bound(reference.entries - 1) {}
  bool coded() const { return bound >= 2; }  ///< else there is but one older entry
  unsigned kind() const { return number_class(bound); }
  unsigned width() const { return std::min(static_cast<unsigned>(std::bit_width(value)), kWide); }
  std::uint32_t value, bound;
};
/// Bits that follow a width.
constexpr unsigned bits_below(unsigned width) {
  return width == kWide ? kWideBits : width > 0 ? width - 1 : 0;
}
/// A width and the bits below it are put in so many pieces, at most.
inline constexpr unsigned kMostPieces = 1 + (kWideBits + kProbabilityBits - 1) / kProbabilityBits;

}  // namespace cvr::codecs::csgv_ctx
