// The two look-ups of the compressed_segmentation encoder: the labels of the block at hand, and the
// tables written so far.
//
// Part of compressed_segmentation.cpp, in a file of its own for length. Neither allocates per
// block.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "volumes/label_hash.hpp"

#if defined(__AVX2__) && !defined(CVR_SCALAR)
#include <immintrin.h>
#define CVR_SEGMENTATION_AVX2 1
#endif

namespace cvr::volumes::segmentation {

/// The distinct labels of a block in order of discovery. Few labels are searched one after another,
/// many through a hash table whose slots are valid for one block only (their stamp says which), so
/// that nothing is cleared or allocated per block.
template <class W>
class Palette {
 public:
  explicit Palette(std::uint64_t capacity) : labels_(capacity + kLinear) {}

  void clear() {
    size_ = 0;
    ++stamp_;
  }
  std::uint32_t size() const { return size_; }
  const W* labels() const { return labels_.data(); }

  std::uint32_t index_of(W label) {
    if (size_ > kLinear) return find_hashed(label);
    const std::uint32_t found = find_linear(label);
    if (found < size_) return found;
    labels_[size_++] = label;
    if (size_ > kLinear) start_hashing();
    return found;
  }

 private:
  static constexpr std::uint32_t kLinear = 32;
  struct Slot {
    std::uint32_t stamp = 0;
    std::uint32_t index = 0;
  };

  /// size_ if the label is absent.
  std::uint32_t find_linear(W label) const {
#if defined(CVR_SEGMENTATION_AVX2)
    if constexpr (sizeof(W) == 4) {
      const __m256i wanted = _mm256_set1_epi32(static_cast<int>(label));
      for (std::uint32_t i = 0; i < size_; i += 8) {
        const __m256i here =
            _mm256_loadu_si256(reinterpret_cast<const __m256i*>(labels_.data() + i));
        const auto hit = static_cast<unsigned>(
            _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(here, wanted))));
        if (hit != 0)
          return std::min<std::uint32_t>(size_,
                                         i + static_cast<std::uint32_t>(std::countr_zero(hit)));
      }
    } else {
      const __m256i wanted = _mm256_set1_epi64x(static_cast<long long>(label));
      for (std::uint32_t i = 0; i < size_; i += 4) {
        const __m256i here =
            _mm256_loadu_si256(reinterpret_cast<const __m256i*>(labels_.data() + i));
        const auto hit = static_cast<unsigned>(
            _mm256_movemask_pd(_mm256_castsi256_pd(_mm256_cmpeq_epi64(here, wanted))));
        if (hit != 0)
          return std::min<std::uint32_t>(size_,
                                         i + static_cast<std::uint32_t>(std::countr_zero(hit)));
      }
    }
    return size_;
#else
    std::uint32_t i = 0;
    while (i < size_ && labels_[i] != label) ++i;
    return i;
#endif
  }

  Slot& slot_of(W label) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = hash_of(label) & mask;
    while (slots_[at].stamp == stamp_ && labels_[slots_[at].index] != label) at = (at + 1) & mask;
    return slots_[at];
  }
  void start_hashing() {
    if (slots_.empty()) slots_.resize(std::bit_ceil(2 * labels_.size()));
    for (std::uint32_t i = 0; i < size_; ++i) slot_of(labels_[i]) = {stamp_, i};
  }
  std::uint32_t find_hashed(W label) {
    Slot& slot = slot_of(label);
    if (slot.stamp != stamp_) {
      slot = {stamp_, size_};
      labels_[size_++] = label;
    }
    return slot.index;
  }

  std::vector<W> labels_;
  std::vector<Slot> slots_;
  std::uint32_t size_ = 0;
  std::uint32_t stamp_ = 0;
};

/// The tables written so far, found by content.
class TableIndex {
 public:
  TableIndex() : slots_(256) {}

  /// The offset of an equal table in `channel`, or `here`, which is remembered as its place: the
  /// caller then writes it there.
  std::uint64_t find_or_add(const std::uint32_t* channel, const std::uint32_t* table,
                            std::uint32_t words, std::uint64_t here) {
    std::uint64_t hash = words;
    for (std::uint32_t i = 0; i < words; ++i)
      hash = (std::rotl(hash, 23) ^ table[i]) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = hash & mask;
    for (; slots_[at].words != 0; at = (at + 1) & mask) {
      const Slot& slot = slots_[at];
      if (slot.hash == static_cast<std::uint32_t>(hash) && slot.words == words &&
          std::equal(table, table + words, channel + slot.offset)) {
        return slot.offset;
      }
    }
    slots_[at] = {here, words, static_cast<std::uint32_t>(hash)};
    if (++used_ * 2 > slots_.size()) grow();
    return here;
  }

 private:
  struct Slot {
    std::uint64_t offset = 0;
    std::uint32_t words = 0;
    std::uint32_t hash = 0;
  };
  void grow() {
    std::vector<Slot> old(slots_.size() * 2);
    old.swap(slots_);
    const std::size_t mask = slots_.size() - 1;
    for (const Slot& slot : old) {
      if (slot.words == 0) continue;
      std::size_t at = slot.hash & mask;
      while (slots_[at].words != 0) at = (at + 1) & mask;
      slots_[at] = slot;
    }
  }
  std::vector<Slot> slots_;
  std::size_t used_ = 0;
};

}  // namespace cvr::volumes::segmentation
