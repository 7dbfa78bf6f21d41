// Random codes into random books: an encoding that shows nothing of a volume and costs a decoder what any other of its bits does
// (Fout & Ma 2007, section 6.3 and Figure 9: times that do not depend on data).
#pragma once

#include "codecs/tvq/train.hpp"

namespace cvr::codecs::tvq {

/// One sub-volume of `blocks` with books of 2^options.bits code vectors, drawn by options.seed: codes and entries are uniform, the sums reach
/// across the range of the domain.
SubVolume random_part(const Scheme& scheme, const Domain& domain, const Extent& blocks, const Options& options);

}  // namespace cvr::codecs::tvq
