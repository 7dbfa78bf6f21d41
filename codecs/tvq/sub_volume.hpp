// One sub-volume: books are trained with its blocks, or with a sample of the blocks that its place
// has at all time steps, and blocks are coded with them.
#pragma once

#include "codecs/tvq/train.hpp"

namespace cvr::codecs::tvq {

/// Blocks of 64 samples and their means.
struct Blocks {
  explicit Blocks(std::vector<float> of_samples);
  std::size_t count() const { return means.size(); }
  std::vector<float> samples;
  std::vector<double> means;
  bool transformed =
      false;  ///< `samples` are coefficients in the basis of what was trained with them
};

/// Books as a file has them, and what coding with them takes.
struct Trained {
  BookSet set;
  std::array<CodeVectors, kMaxBooks>
      code_vectors;  ///< what a decoder makes of them, in samples or coefficients
  unsigned dc_bits = 0;
  std::int32_t dc_base = 0;  ///< of vq, which has no DC
  double tau = 0;  ///< of tvq with classes: the root mean squared error that a class may lose
};

/// Trains with `sample`, which stands for `blocks` blocks and, where options.rate > 0, gets
/// `budget` bits for their planes and the books. Of tvq the sample is transformed.
Trained train(const Scheme& scheme, const Domain& domain, Blocks& sample, double blocks,
              double budget, const Options& options, unsigned threads);

/// Codes blocks, with a lattice of DC of their own. `grid`: blocks along x, y, z.
SubVolume code(const Scheme& scheme, const Domain& domain, const Trained& trained,
               const Extent& grid, Blocks blocks, const Options& options, unsigned threads);

}  // namespace cvr::codecs::tvq
