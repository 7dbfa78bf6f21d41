// Random codes into random books: an encoding that shows nothing of a volume and costs a decoder
// what any other of its bits does (Fout & Ma 2007, section 6.3 and Figure 9: times that do not
// depend on data).
#pragma once

#include "codecs/tvq/train.hpp"

namespace cvr::codecs::tvq {

/// Books of 2^options.bits code vectors, drawn by options.seed: entries are uniform, the sums reach
/// across the range of the domain.
BookSet random_books(const Scheme& scheme, const Domain& domain, const Options& options);
/// Uniform codes of `grid` blocks, drawn by options.seed and the number of the part.
SubVolume random_part(const Scheme& scheme, const Domain& domain, const BookSet& set,
                      const Extent& grid, const Options& options, std::uint64_t part);

}  // namespace cvr::codecs::tvq
