// Counts symbols by the context in which they are coded, for the empirical entropy of a codec's own
// model.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>

namespace cvr::codecs::csgv {

class SymbolTally {
 public:
  void add(std::uint32_t context, std::uint32_t symbol) {
    ++counts_[std::uint64_t{context} << 32 | symbol];
  }
  /// Bits that are equally likely.
  void add_plain(std::uint64_t bits) { plain_ += bits; }

  void merge(const SymbolTally& other) {
    plain_ += other.plain_;
    for (const auto& [key, count] : other.counts_) counts_[key] += count;
  }

  /// Bits that a coder would take that knew how often each symbol occurs in each context, its
  /// tables for nothing.
  double entropy_bits() const {
    const std::map<std::uint64_t, std::uint64_t> ordered(
        counts_.begin(), counts_.end());  // sums do not depend on the order of counting
    std::map<std::uint64_t, std::uint64_t> totals;
    for (const auto& [key, count] : ordered) totals[key >> 32] += count;
    auto bits = static_cast<double>(plain_);
    for (const auto& [key, count] : ordered) {
      bits -= static_cast<double>(count) *
              std::log2(static_cast<double>(count) / static_cast<double>(totals[key >> 32]));
    }
    return bits;
  }

 private:
  std::unordered_map<std::uint64_t, std::uint64_t> counts_;
  std::uint64_t plain_ = 0;
};

}  // namespace cvr::codecs::csgv
