// Who gets how many bits and code vectors.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace cvr::codecs::tvq {

/// What a code of b bits costs: [b] from the least number of bits on. Infinite distortion marks
/// what cannot be had.
struct BitCurve {
  unsigned first = 0;              ///< bits of the first entry
  std::vector<double> distortion;  ///< of all blocks together
  std::vector<double> book_bits;   ///< size of the book in the file
};

/// The bits that minimise the sum of the distortions with blocks * (sum of bits) + books <= budget,
/// by trying all; of equals the fewest bits. Where nothing fits, the least of all.
std::vector<unsigned> choose_bits(std::span<const BitCurve> curves, double blocks, double budget);

/// Distortion by the paper's model, n s^2 2^(-2 b / n) a block, with s^2 the mean variance of a
/// dimension over the blocks (Fout & Ma 2007, section 4.1; Shoham & Gersho 1988).
std::vector<double> model_curve(unsigned dimensions, double variance, double blocks, unsigned most);

/// A class that wants code vectors of a partition: the paper after Ramamurthi & Gersho 1986. Its
/// distortion with N code vectors is probability * amplitude * N^(-2 / dimensions).
struct ChapterDemand {
  double probability;
  double amplitude;     ///< dimensions * geometric mean of the variances
  unsigned dimensions;  ///< those with variance
  std::uint32_t most;   ///< distinct vectors, or members
};
/// Shares `entries` >= demands.size() code vectors among the classes, at least one and at most
/// `most` each, with equal slopes of distortion; whole numbers by the largest remainder, ties to
/// the first. What nobody can use is left over.
std::vector<std::uint32_t> share_entries(std::span<const ChapterDemand> demands,
                                         std::uint32_t entries);

}  // namespace cvr::codecs::tvq
