// What has to hold of a dataset before the library reads its voxels: filters that are there, chunks
// that fit, and every file and dataset that it takes voxels from, which the library would otherwise
// replace by fill values without a word. To be called in the child process of Hdf5Process alone.
#pragma once

#include "volumes/io/hdf5_objects.hpp"

namespace cvr::volumes {

/// Throws InputError naming what is wrong: filter, chunk, external file, source of a virtual
/// dataset.
void check_hdf5_storage(Hdf5Bounds& bounds, const Hdf5Dataset& dataset);

/// The dataset once more, with external and virtual files looked for where check_hdf5_storage did,
/// and with a chunk cache of one layer of chunks, one deep along the axes `slow`, of voxels of
/// `width` bytes. Returns the extent of its chunks; empty where it has none.
std::vector<hsize_t> reopen_hdf5_dataset(Hdf5Dataset& dataset, const std::vector<int>& slow,
                                         std::size_t width);

}  // namespace cvr::volumes
