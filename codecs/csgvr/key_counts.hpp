// How often keys occur: numbers them in the order in which they are met. Open addressing, no removal.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volumes/label_hash.hpp"

namespace cvr::codecs::csgvr {

class KeyCounts {
 public:
  struct Entry {
    std::uint64_t key, count;
  };
  KeyCounts() : slots_(kSlots) {}

  /// The number of a key, which has occurred `count` times more.
  std::uint32_t note(std::uint64_t key, std::uint64_t count = 1) {
    std::size_t at = slot(key);
    for (; slots_[at] != 0; at = (at + 1) & (slots_.size() - 1)) {
      Entry& entry = entries_[slots_[at] - 1];
      if (entry.key != key) continue;
      entry.count += count;
      return slots_[at] - 1;
    }
    entries_.push_back({key, count});
    const auto number = static_cast<std::uint32_t>(entries_.size());
    slots_[at] = number;
    if (2 * entries_.size() > slots_.size()) grow();
    return number - 1;
  }
  /// Appends the numbers of keys that have each occurred once more. What they need of memory is asked for ahead of time.
  void note(std::span<const std::uint64_t> keys, std::vector<std::uint32_t>& numbers) {
    constexpr std::size_t kSlotAhead = 64;
    constexpr std::size_t kEntryAhead = 16;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (i + kSlotAhead < keys.size()) __builtin_prefetch(&slots_[slot(keys[i + kSlotAhead])]);
      if (i + kEntryAhead < keys.size()) {
        if (const std::uint32_t number = slots_[slot(keys[i + kEntryAhead])]; number != 0)
          __builtin_prefetch(&entries_[number - 1]);
      }
      numbers.push_back(note(keys[i]));
    }
  }
  /// How often a key has occurred.
  std::uint64_t count(std::uint64_t key) const {
    for (std::size_t at = slot(key); slots_[at] != 0; at = (at + 1) & (slots_.size() - 1)) {
      if (const Entry& entry = entries_[slots_[at] - 1]; entry.key == key) return entry.count;
    }
    return 0;
  }
  const std::vector<Entry>& entries() const { return entries_; }
  /// Forgets all keys, and keeps the memory.
  void clear() {
    entries_.clear();
    slots_.assign(kSlots, 0);
  }

 private:
  static constexpr std::size_t kSlots = 1024;  ///< of an empty table

  std::size_t slot(std::uint64_t key) const { return volumes::hash_of(key) & (slots_.size() - 1); }
  void grow() {
    slots_.assign(4 * slots_.size(), 0);
    constexpr std::size_t kAhead = 64;
    for (std::uint32_t i = 0; i < entries_.size(); ++i) {
      if (i + kAhead < entries_.size())
        __builtin_prefetch(&slots_[slot(entries_[i + kAhead].key)], 1);
      std::size_t at = slot(entries_[i].key);
      while (slots_[at] != 0) at = (at + 1) & (slots_.size() - 1);
      slots_[at] = i + 1;
    }
  }

  std::vector<Entry> entries_;
  std::vector<std::uint32_t> slots_;  ///< numbers + 1; a power of two
};

}  // namespace cvr::codecs::csgvr
