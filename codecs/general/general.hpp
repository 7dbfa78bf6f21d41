// General-purpose compressors over the voxels as they lie in memory: what a volume costs without
// knowing that it is one.
//
// All accept every voxel type, read their source in slabs of whole planes and know one level.
// Layouts: FORMAT.md.
#pragma once

#include "codecs/codec.hpp"

namespace cvr::codecs {

const Codec& zstd_codec();
const Codec& lzma_codec();
const Codec& hdf5_gzip_codec();

}  // namespace cvr::codecs
