// Writing where an HDF5 file is already: what of it may be replaced.
#pragma once

#include <string>

namespace cvr::volumes {

/// Whether a file is there that has to be kept but for one dataset: `path` exists and `dataset` was
/// named. Throws InputError where nothing may be written: a file without HDF5, one that cannot be
/// read, and, without a dataset's name, one that holds more than the volume `/written` that is
/// about to be written. Asks a child process.
bool keeps_existing_hdf5(const std::string& path, const std::string& dataset,
                         const std::string& written);

/// Takes away the dataset `name` of the open file, or the link of this name. Throws InputError
/// where a group has this name, and where the way there leads over links: writing never leaves the
/// file. For the child process alone.
void remove_hdf5_dataset(const std::string& path, long long file, const std::string& name);

}  // namespace cvr::volumes
