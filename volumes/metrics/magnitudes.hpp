// Many numbers that are not negative, kept as counts: in 2^21 bins, each 2^-10 of its numbers wide,
// whatever their size. So quantiles of volumes of any size need 16 MiB.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace cvr::volumes {

class Magnitudes {
 public:
  /// `magnitude` >= 0; infinity is a number here, NaN is not.
  void add(double magnitude) {
    ++counts_[bin_of(magnitude)];
    ++total_;
  }
  void add(const Magnitudes& other) {
    for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
    total_ += other.total_;
  }
  std::uint64_t total() const { return total_; }
  /// The least number of the bin that holds the number of this rank, 0 <= rank < total(), in
  /// ascending order.
  double at_rank(std::uint64_t rank) const {
    std::size_t bin = 0;
    for (std::uint64_t before = counts_[0]; before <= rank; before += counts_[bin]) ++bin;
    return std::bit_cast<double>(static_cast<std::uint64_t>(bin) << kDropped);
  }

 private:
  static constexpr unsigned kDropped = 42;  // of the 52 bits after the binary point
  static std::size_t bin_of(double magnitude) {
    return std::bit_cast<std::uint64_t>(magnitude + 0.0) >> kDropped;
  }

  std::vector<std::uint64_t> counts_ =
      std::vector<std::uint64_t>(std::size_t{1} << (63 - kDropped));
  std::uint64_t total_ = 0;
};

}  // namespace cvr::volumes
