// Counts symbols by the context in which they are coded, for the empirical entropy of a codec's own model.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace cvr::codecs::csgv {

class SymbolTally {
 public:
  void add(std::size_t context, std::size_t symbol) {
    if (context >= counts_.size()) counts_.resize(context + 1);
    auto& symbols = counts_[context];
    if (symbol >= symbols.size()) symbols.resize(symbol + 1);
    ++symbols[symbol];
  }
  /// Bits that are equally likely.
  void add_plain(std::uint64_t bits) { plain_ += bits; }

  void merge(const SymbolTally& other) {
    plain_ += other.plain_;
    if (other.counts_.size() > counts_.size()) counts_.resize(other.counts_.size());
    for (std::size_t c = 0; c < other.counts_.size(); ++c) {
      const auto& theirs = other.counts_[c];
      if (theirs.size() > counts_[c].size()) counts_[c].resize(theirs.size());
      for (std::size_t s = 0; s < theirs.size(); ++s) counts_[c][s] += theirs[s];
    }
  }

  /// Bits that a coder would take that knew how often each symbol occurs in each context, its tables for nothing.
  double entropy_bits() const {
    double bits = static_cast<double>(plain_);
    for (const auto& symbols : counts_) {
      double total = 0;
      for (const std::uint64_t n : symbols) total += static_cast<double>(n);
      for (const std::uint64_t n : symbols) {
        if (n > 0) bits -= static_cast<double>(n) * std::log2(static_cast<double>(n) / total);
      }
    }
    return bits;
  }

 private:
  std::vector<std::vector<std::uint64_t>> counts_;
  std::uint64_t plain_ = 0;
};

}  // namespace cvr::codecs::csgv
