// Symbols in their contexts, and how often each occurs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codecs/csgv_ctx/contexts.hpp"

namespace cvr::codecs::csgv_ctx {

inline constexpr unsigned kSymbolBits = 4;

/// A symbol in its context: bits 0..3 the symbol, 4..17 the dynamic bits, 18..31 the static ones.
/// So in ascending order events of a context stand together, those of a static context too, and the
/// finest level first.
using Event = std::uint32_t;
constexpr Event make_event(std::uint32_t static_bits, std::uint32_t dynamic_bits,
                           std::uint32_t symbol) {
  return symbol | dynamic_bits << kSymbolBits | static_bits << (kSymbolBits + kDynamicBits);
}
constexpr std::uint32_t static_of(Event event) { return event >> (kSymbolBits + kDynamicBits); }
constexpr std::uint32_t dynamic_of(Event event) {
  return event >> kSymbolBits & ((1u << kDynamicBits) - 1);
}
constexpr std::uint32_t symbol_of(Event event) { return event & ((1u << kSymbolBits) - 1); }

/// Sums depend on what was added alone, not on its order.
class EventCounts {
 public:
  struct Entry {
    Event event;
    std::uint32_t count;
  };
  void add(std::span<const Event> events);
  void merge(const EventCounts& other);
  /// Each event once, ascending.
  std::vector<Entry> entries() const;

 private:
  void count_pending();

  std::vector<Entry> counted_;  ///< ascending
  std::vector<Event> pending_;  ///< not yet among them
};

}  // namespace cvr::codecs::csgv_ctx
