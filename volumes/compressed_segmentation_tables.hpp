// The two look-ups of the compressed_segmentation encoder: the labels of the block at hand, and the
// tables written so far.
//
// Part of compressed_segmentation.cpp, in a file of its own for length. Neither allocates per
// block.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#if defined(__AVX2__) && !defined(CVR_SCALAR)
#include <immintrin.h>
#define CVR_SEGMENTATION_AVX2 1
#endif

namespace cvr::volumes::segmentation {

/// The labels of a block in order of discovery. Few labels are searched one after another; where
/// there are more, every further one gets an entry of its own, and sorting finds the equal ones.
template <class W>
class Palette {
 public:
  explicit Palette(std::uint64_t capacity) : labels_(capacity + kLinear) {}

  void clear() { size_ = 0; }
  std::uint32_t size() const { return size_; }
  const W* labels() const { return labels_.data(); }
  /// Whether no label has two entries.
  bool distinct() const { return size_ <= kLinear; }

  std::uint32_t index_of(W label) {
    const std::uint32_t found = distinct() ? find_linear(label) : size_;
    if (found == size_) labels_[size_++] = label;
    return found;
  }

 private:
  static constexpr std::uint32_t kLinear = 32;
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

  std::vector<W> labels_;
  std::uint32_t size_ = 0;
};

/// A palette entry to be sorted.
template <class W>
struct Entry {
  W label;
  std::uint32_t index;
};

/// Sorts all but groups of kFew neighbours or less: into buckets by the highest bits that differ,
/// and so on within large buckets. `spare` holds as many entries.
template <class W>
void sort_roughly(Entry<W>* entries, Entry<W>* spare, std::uint32_t count) {
  constexpr unsigned kBits = 8;
  constexpr std::uint32_t kFew = 16;
  W differing = 0;
  for (std::uint32_t i = 1; i < count; ++i) differing |= entries[i].label ^ entries[0].label;
  if (count <= kFew || differing == 0) return;
  const auto width = static_cast<unsigned>(std::bit_width(differing));
  const unsigned shift = width > kBits ? width - kBits : 0;
  const auto bucket_of = [shift](W label) { return label >> shift & ((1u << kBits) - 1); };
  std::array<std::uint32_t, 1u << kBits> ends{};
  for (std::uint32_t i = 0; i < count; ++i) ++ends[bucket_of(entries[i].label)];
  std::exclusive_scan(ends.begin(), ends.end(), ends.begin(), 0u);
  for (std::uint32_t i = 0; i < count; ++i) spare[ends[bucket_of(entries[i].label)]++] = entries[i];
  std::copy_n(spare, count, entries);
  std::uint32_t begin = 0;
  for (const std::uint32_t end : ends) {
    if (end - begin > kFew) sort_roughly(entries + begin, spare, end - begin);
    begin = end;
  }
}

/// Sorts by label. A few nanoseconds an entry, and whatever the labels, a bounded multiple of that.
template <class W>
void sort_entries(Entry<W>* entries, Entry<W>* spare, std::uint32_t count) {
  sort_roughly(entries, spare, count);
  for (std::uint32_t i = 1; i < count; ++i) {
    const Entry<W> entry = entries[i];
    std::uint32_t at = i;
    for (; at > 0 && entries[at - 1].label > entry.label; --at) entries[at] = entries[at - 1];
    entries[at] = entry;
  }
}

/// The tables written so far, found by content.
class TableIndex {
 public:
  TableIndex() : slots_(256) {}

  /// The offset of an equal table in `channel`, or `here`, which is remembered as its place: the
  /// caller then writes it there.
  std::uint64_t find_or_add(const std::uint32_t* channel, const std::uint32_t* table,
                            std::uint32_t words, std::uint64_t here) {
    const std::uint64_t hash = hash_of_words(table, words);
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
  static std::uint64_t hash_of_words(const std::uint32_t* table, std::uint32_t words) {
    std::uint64_t hash = words;
    const auto mix = [&hash](std::uint64_t next) {
      hash = (std::rotl(hash, 23) ^ next) * 0x9e3779b97f4a7c15u;
    };
    for (std::uint32_t i = 0; i + 1 < words; i += 2)
      mix(table[i] | std::uint64_t{table[i + 1]} << 32);
    if (words % 2 != 0) mix(table[words - 1]);
    return hash ^ hash >> 32;
  }
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
