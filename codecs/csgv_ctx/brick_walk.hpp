// From a label multigrid to the symbols of one brick, each in its context.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codecs/csgv/operations.hpp"
#include "codecs/csgv_ctx/events.hpp"
#include "codecs/csgv_ctx/reference.hpp"

namespace cvr::codecs::csgv_ctx {

/// Reused from brick to brick; one per thread.
class BrickWalk {
 public:
  void run(const csgv::LabelGrid& grid, const csgv::Validity& validity);

  /// Of all nodes but the root, level by level; none of a constant brick.
  std::span<const Event> events() const { return {events_.data(), event_count_}; }
  /// Of the symbols "delta", in their order.
  std::span<const Reference> references() const { return references_; }
  /// The labels of the brick, each once, in the order of their first use: the root's first.
  std::span<const std::uint32_t> palette() const { return palette_; }

 private:
  void block(const csgv::LabelGrid& grid, const csgv::Validity& validity, unsigned level,
             std::uint32_t n, unsigned valid, unsigned constant);
  unsigned palette_operation(std::uint32_t label);

  std::vector<Event> events_;
  std::size_t event_count_ = 0;
  std::vector<Reference> references_;
  std::vector<std::uint32_t> palette_;
  std::size_t last_advance_ = 0;  ///< events up to the last use of a new entry
  csgv::PaletteIndex index_;
  std::vector<std::uint32_t> active_, next_;
};

}  // namespace cvr::codecs::csgv_ctx
