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
class ContextCounts {
 public:
  struct Entry {
    std::uint32_t context = 0;  ///< static and dynamic bits
    std::uint32_t total = 0;    ///< 0: an empty place
    std::array<std::uint32_t, kSymbols> symbols{};
  };
  ContextCounts() : table_(std::size_t{1} << 10) {}
  void add(Event event) { ++count(event & kContext, 1)[symbol_of(event)]; }
  void merge(const ContextCounts& other);
  /// Entries of one pair of trees, by ascending static bits; those that agree on them in any order.
  std::vector<Entry> entries(unsigned pair) const;

 private:
  static constexpr std::uint32_t kContext = (1u << (kStaticBits + kDynamicBits)) - 1;
  std::array<std::uint32_t, kSymbols>& count(std::uint32_t context, std::uint32_t times) {
    std::size_t mask = table_.size() - 1;
    for (std::size_t at = (context * 0x9e3779b1u >> 4) & mask;; at = (at + 1) & mask) {
      Entry& entry = table_[at];
      if (entry.total == 0) {
        if (2 * used_ >= table_.size()) {
          grow();
          return count(context, times);
        }
        ++used_;
        entry.context = context;
      }
      if (entry.context == context) {
        entry.total += times;
        return entry.symbols;
      }
    }
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

ContextModel train(const ContextCounts& contexts, const NumberCounts& numbers, const ContextBits& bits);

}  // namespace cvr::codecs::csgv_ctx
