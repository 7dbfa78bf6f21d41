// Reading and writing volume files; the format follows from the name.
//
//   FILE.h5:/path/to/dataset   HDF5; without a path the only dataset; of rank 4 (t z y x) a series
//   FILE.nrrd FILE.nhdr        NRRD, raw and gzip, attached and detached; of dimension 4 (x y z t) a series
//   FILE.nii FILE.nii.gz       NIfTI-1; 4D is a series
//   FILE.raw                   raw voxels, x fastest, beside a sidecar FILE.raw.yaml; mapped, data() without a copy
//   FOLDER or FOLDER/SCALE     Neuroglancer precomputed (a folder with an `info` file); written for a name that ends in "/" or
//                              ".precomputed", u8 and u16 labels as u32
//
// A series is one volume with its time steps stacked along z (VolumeInfo::time_steps); NAME[T] is
// its step T alone, NAME[A:B] the steps A to B - 1. Precomputed folders hold single volumes only.
//
// Sources read boxes without the rest of the file, except gzipped NRRD and NIfTI, which inflate
// into memory at the first read. Writers draw slabs, so the volume need not fit into memory.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/source.hpp"

namespace cvr::volumes {

/// What the caller says of a file; goes before what the file says.
struct OpenOptions {
  std::optional<VolumeKind> kind;  ///< the formats that cannot say it and u8 volumes leave it open
  /// Names of the stored axes in the order in which the format lists them (HDF5: slowest first, the
  /// others: x first), each one of t z y x c; empty: as the file says, else as the format's rule
  /// is.
  std::string axes;
  bool allow_external = false;  ///< read files that the volume names outside its own folder
};

/// Opens a volume file for reading by boxes. Signed integers become unsigned labels; a negative one
/// is an error when it is read. Throws InputError that names the file, the position (byte offset,
/// header line or attribute) and what was expected.
std::unique_ptr<VolumeSource> open_volume(const std::string& path, const OpenOptions& options = {});
std::unique_ptr<VolumeSource> open_volume(const std::string& path, std::optional<VolumeKind> kind);

/// Writes a volume from slabs of its source. An existing plain file, or a precomputed folder that
/// holds nothing but what this project wrote, is replaced as a whole, and only when the new one is
/// complete. Throws OutputError for what cannot be written, InputError for an output that would
/// replace a file of the source and for what the format cannot hold (NIfTI: more than 32767 voxels
/// an axis, units that are no lengths; precomputed: offsets that are no whole number of voxels).
void write_volume(const std::string& path, const VolumeSource& source);

/// The files and folders that writing a volume of this name makes or replaces, its sidecar or data
/// file among them. Throws InputError where the name is not that of a volume.
std::vector<std::string> volume_outputs(const std::string& path);

/// Throws as write_volume does, as far as can be told before there is a volume: InputError where
/// one of `inputs` would be replaced, OutputError for names that cannot be written. For commands
/// that work long before they write.
void check_volume_output(const std::string& path, const std::vector<std::string>& inputs);

/// Whether the name is that of a volume file or folder, as opposed to an encoded file. Looks at the
/// disk only for folders.
bool is_volume_path(const std::string& path);

}  // namespace cvr::volumes
