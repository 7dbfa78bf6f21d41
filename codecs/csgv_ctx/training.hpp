// Fits the tables of a volume to what was counted of it: grows context trees by description length, then makes few distributions of
// their many leaves. All arithmetic is on integers: every build makes the same bytes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "codecs/csgv_ctx/model.hpp"

namespace cvr::codecs::csgv_ctx {

/// A symbol in its context: bits 0..13 the static ones, 14..27 the dynamic ones, 28..31 the symbol.
using Event = std::uint32_t;
constexpr Event make_event(std::uint32_t static_bits, std::uint32_t dynamic_bits, std::uint32_t symbol) {
  return static_bits | dynamic_bits << kStaticBits | symbol << (kStaticBits + kDynamicBits);
}
constexpr std::uint32_t static_of(Event event) { return event & ((1u << kStaticBits) - 1); }
constexpr std::uint32_t dynamic_of(Event event) { return event >> kStaticBits & ((1u << kDynamicBits) - 1); }
constexpr std::uint32_t symbol_of(Event event) { return event >> (kStaticBits + kDynamicBits); }

/// How often each symbol occurs in each context. Open addressing; grows.
class EventCounts {
 public:
  struct Entry {
    Event event = 0;
    std::uint32_t count = 0;  ///< 0: an empty place
  };
  EventCounts() : table_(std::size_t{1} << 12) {}
  void add(Event event, std::uint32_t times = 1) {
    Entry* entry = place(event);
    if (entry->count == 0) {
      if (2 * ++used_ > table_.size()) {
        grow();
        entry = place(event);
      }
      entry->event = event;
    }
    entry->count += times;
  }
  void merge(const EventCounts& other);
  /// Entries of one pair of trees, by ascending static bits; those that agree on them in any order.
  std::vector<Entry> entries(unsigned pair) const;

 private:
  /// Where the event is, or would be.
  Entry* place(Event event) {
    const std::size_t mask = table_.size() - 1;
    std::size_t at = (event * 0x9e3779b1u >> 8) & mask;
    while (table_[at].count != 0 && table_[at].event != event) at = (at + 1) & mask;
    return &table_[at];
  }
  void grow();

  std::vector<Entry> table_;
  std::size_t used_ = 0;
};

/// How often each width of a number occurs.
using NumberCounts = std::array<std::array<std::uint64_t, kSymbols>, kNumberKinds>;

/// The bits of a context that trees may ask for.
struct ContextBits {
  std::uint32_t statics = (1u << kStaticBits) - 1, dynamics = (1u << kDynamicBits) - 1;
};

ContextModel train(const EventCounts& events, const NumberCounts& numbers, const ContextBits& bits);

}  // namespace cvr::codecs::csgv_ctx
