// Few distributions for the many leaves of context trees.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codecs/csgv_ctx/description_length.hpp"
#include "codecs/csgv_ctx/model.hpp"

namespace cvr::codecs::csgv_ctx {

/// k-means by description length, the farthest leaves first.
template <std::size_t N>
class Clustering {
 public:
  Clustering(std::span<const Counts<N>> leaves, std::uint32_t possible)
      : leaves_(leaves), possible_(possible) {
    const std::size_t count =
        std::min<std::size_t>({leaves.size(), kMostRows, leaves.size() / kLeavesARow + 4});
    nearest.assign(leaves.size(), 0);
    begin(count);
    for (unsigned i = 0; i < kIterations; ++i) {
      refit();
      assign();
    }
    refit();
    drop_unused();
  }
  std::vector<Distribution> distributions;
  std::vector<std::uint32_t> nearest;  ///< distribution of each leaf

 private:
  static constexpr unsigned kIterations = 4;
  static constexpr std::size_t kLeavesARow = 3;  ///< leaves for each distribution, about
  using Lengths = std::array<Cost, N>;
  /// Bits of each symbol.
  static Lengths lengths_of(const Distribution& distribution) {
    Lengths lengths{};
    for (unsigned s = 0; s < N; ++s) {
      if (distribution.frequency[s] > 0)
        lengths[s] = bits(kProbabilityBits) - log2_of(distribution.frequency[s]);
    }
    return lengths;
  }
  static Cost cost(const Counts<N>& counts, const Lengths& lengths) {
    Cost sum = 0;
    for (unsigned s = 0; s < N; ++s) sum += counts[s] * lengths[s];
    return sum;
  }
  static std::array<std::uint64_t, kSymbols> widened(const Counts<N>& counts) {
    std::array<std::uint64_t, kSymbols> wide{};
    std::ranges::copy(counts, wide.begin());
    return wide;
  }

  void begin(std::size_t count) {
    std::vector<Cost> best(leaves_.size());
    std::vector<Cost> own(leaves_.size());
    std::size_t pick = 0;
    std::uint64_t most = 0;
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      own[i] = cost(leaves_[i], lengths_of(fit_distribution(widened(leaves_[i]), possible_)));
      std::uint64_t total = 0;
      for (const std::uint32_t n : leaves_[i]) total += n;
      if (total > most) {
        most = total;
        pick = i;
      }
    }
    while (distributions.size() < count) {
      distributions.push_back(fit_distribution(widened(leaves_[pick]), possible_));
      const Lengths lengths = lengths_of(distributions.back());
      Cost worst = -1;
      for (std::size_t i = 0; i < leaves_.size(); ++i) {
        const Cost here = cost(leaves_[i], lengths);
        if (distributions.size() == 1 || here < best[i]) {
          best[i] = here;
          nearest[i] = static_cast<std::uint32_t>(distributions.size() - 1);
        }
        if (best[i] - own[i] > worst) {
          worst = best[i] - own[i];
          pick = i;
        }
      }
    }
  }

  void refit() {
    std::vector<std::array<std::uint64_t, kSymbols>> sums(distributions.size());
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      for (unsigned s = 0; s < N; ++s) sums[nearest[i]][s] += leaves_[i][s];
    }
    for (std::size_t k = 0; k < sums.size(); ++k)
      distributions[k] = fit_distribution(sums[k], possible_);
  }

  void assign() {
    std::vector<Lengths> lengths;
    for (const Distribution& d : distributions) lengths.push_back(lengths_of(d));
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      Cost least = cost(leaves_[i], lengths[nearest[i]]);
      for (std::uint32_t k = 0; k < lengths.size(); ++k) {
        const Cost here = cost(leaves_[i], lengths[k]);
        if (here < least) {
          least = here;
          nearest[i] = k;
        }
      }
    }
  }

  void drop_unused() {
    std::vector<std::uint32_t> place(distributions.size(), 0);
    for (const std::uint32_t k : nearest) place[k] = 1;
    std::uint32_t kept = 0;
    for (std::size_t k = 0; k < place.size(); ++k) {
      if (place[k] == 0) continue;
      distributions[kept] = distributions[k];
      place[k] = kept++;
    }
    distributions.resize(kept);
    for (std::uint32_t& k : nearest) k = place[k];
  }

  std::span<const Counts<N>> leaves_;
  std::uint32_t possible_;
};

}  // namespace cvr::codecs::csgv_ctx
