// Reading and writing volume files; the format follows from the name.
//
//   FILE.h5:/path/to/dataset   HDF5; without a path the only dataset; FILE.h5:/dataset[T] for step T of a 4D series (t z y x)
//   FILE.nrrd FILE.nhdr        NRRD, raw and gzip, attached and detached
//   FILE.nii FILE.nii.gz       NIfTI-1
//   FILE.raw                   raw voxels, x fastest, beside a sidecar FILE.raw.yaml
//   FOLDER or FOLDER/SCALE     Neuroglancer precomputed (a folder with an `info` file)
#pragma once

#include <memory>
#include <string>

#include "volumes/error.hpp"
#include "volumes/source.hpp"

namespace cvr::volumes {

/// Opens a volume file for reading by boxes. Throws InputError that names the file, the position (byte offset, header line or
/// attribute) and what was expected.
std::unique_ptr<VolumeSource> open_volume(const std::string& path);

/// Writes a volume from slabs of its source. Throws InputError (an existing file is replaced only when complete).
void write_volume(const std::string& path, const VolumeSource& source);

/// Whether the name is that of a volume file or folder, as opposed to an encoded file.
bool is_volume_path(const std::string& path);

}  // namespace cvr::volumes
