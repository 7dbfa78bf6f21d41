// Bits of DC and of the codes of all books: by a rate, from what books of every size lose and cost,
// or as they are given.
#pragma once

#include <array>
#include <span>

#include "codecs/tvq/train.hpp"

namespace cvr::codecs::tvq {

/// What the allocation needs to know of a book.
struct Candidate {
  Vectors vectors;
  double weight;      ///< voxels that a unit of squared distance stands for
  unsigned length;    ///< entries of a code vector on a device
  bool coefficients;  ///< whether the file stores these
};

struct Bits {
  unsigned dc;
  std::array<unsigned, kMaxBooks> books{};
  double error = 0;         ///< expected mean squared error, samples
  double active_error = 0;  ///< the same over the blocks that have more than DC
};

/// By `options.rate`, or as `options.bits` gives them. `means` and `candidates`: of all blocks or
/// of a sample that stands for `blocks`; `budget`: bits of the planes of all blocks and of the
/// books together.
Bits allocate(const Scheme& scheme, const Domain& domain, std::span<const double> means,
              std::span<const Candidate> candidates, double blocks, double budget,
              const Options& options, unsigned threads);

}  // namespace cvr::codecs::tvq
