// The palette entry of each label of a brick: open addressing, emptied by a new generation
// for each brick.
#pragma once

#include <cstdint>
#include <vector>

#include "volumes/huge_pages.hpp"
#include "volumes/label_hash.hpp"

namespace cvr::codecs::csgv {

class PaletteIndex {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  /// Forgets everything and makes room for `labels`, a power of two.
  void begin(std::size_t labels) {
    if (slots_.size() != 2 * labels) {
      slots_.assign(2 * labels, {});
      generation_ = 0;
    }
    ++generation_;
  }
  /// The entry of a label; kNone where it has none, and then it gets this one.
  std::uint32_t find_or_add(std::uint32_t label, std::uint32_t entry) {
    const std::uint32_t mask = static_cast<std::uint32_t>(slots_.size()) - 1;
    std::uint32_t at = hash(label) & mask;
    for (; slots_[at].generation == generation_; at = (at + 1) & mask) {
      if (slots_[at].label == label) return slots_[at].entry;
    }
    slots_[at] = {generation_, label, entry};
    return kNone;
  }
  /// Asks for the memory that a label's look-up needs.
  void prefetch(std::uint32_t label) const {
    __builtin_prefetch(&slots_[hash(label) & (slots_.size() - 1)], 1);
  }

 private:
  struct Slot {
    std::uint32_t generation = 0, label = 0, entry = 0;
  };
  static std::uint32_t hash(std::uint32_t label) {
    return static_cast<std::uint32_t>(volumes::hash_of(label));
  }

  std::vector<Slot, volumes::HugePages<Slot>> slots_;
  std::uint32_t generation_ = 0;
};

}  // namespace cvr::codecs::csgv
