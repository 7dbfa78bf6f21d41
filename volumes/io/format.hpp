// What the readers and writers of this folder share: names taken apart, error texts, and how stored
// types become volumes.
//
// A reader turns its header into an Interpretation and an extent that check_extent has accepted, so
// that no size from a file is trusted before it has been compared with the bytes that are there.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "volumes/error.hpp"
#include "volumes/io/io.hpp"
#include "volumes/source.hpp"

namespace cvr::volumes {

/// "[first]" or "[first:end]" behind the name of a series.
struct StepRange {
  std::uint64_t first = 0;
  std::optional<std::uint64_t> end;  ///< one behind the last; none: the first alone
};

/// A volume name taken apart: FILE, FILE:DATASET, FILE[STEPS], FILE:DATASET[STEPS].
struct VolumePath {
  std::string file;
  std::string dataset;             ///< HDF5 only; empty: the only one
  std::optional<StepRange> steps;  ///< of a series; none: all
};

/// Throws InputError "FILE: POSITION: expected EXPECTED, found FOUND"; an empty position is left
/// out.
[[noreturn]] void throw_input_error(const std::string& file, std::string_view position,
                                    std::string_view expected, std::string_view found);

/// Throws OutputError "FILE: cannot write: REASON".
[[noreturn]] void throw_output_error(const std::string& file, std::string_view reason);

/// A voxel type as stored; signed integers of 8, 32 and 64 bits carry the unsigned type of their
/// width, and so do floats of 64 bits.
struct StoredType {
  VoxelType type;
  bool is_signed = false;
  bool is_float64 = false;
};
/// "i8", "f64", ...
std::string name_of(const StoredType& stored);
/// "uint8", "uint16", "uint32", "uint64", "int16", "float32": as NRRD (but for the float) and
/// precomputed name them.
std::string_view long_name_of(VoxelType type);

struct Interpretation {
  VoxelType type;
  VolumeKind kind;
  bool reject_negative =
      false;  ///< stored signed, read as unsigned labels: a negative voxel is an error
  bool whole_numbers = false;  ///< stored as floats, read as labels: see labels_from_floats
};

/// Whether a reader turns floats into labels (Interpretation::whole_numbers).
enum class FloatLabels { kRefused, kConverted };

/// Settles what a stored type means: the caller's hint goes before what the file states, and that
/// before the rule "unsigned types are labels, i16 and floats scalars". Floats that are labels
/// become u32 or u64, the unsigned type of their width. Throws for scalars of other types than u8,
/// u16, i16, f32. `type_name` is the file's own name of the type for errors; empty:
/// name_of(stored).
Interpretation interpret(const std::string& file, StoredType stored, std::optional<VolumeKind> hint,
                         std::optional<VolumeKind> stated,
                         FloatLabels floats = FloatLabels::kRefused,
                         std::string_view type_name = {});

/// Checks (X, Y, Z): no axis is empty and the voxels take at most 2^48 bytes, so that later
/// products cannot overflow.
Extent check_extent(const std::string& file, std::string_view position,
                    const std::array<std::uint64_t, 3>& size, VoxelType type);

/// The time steps of a series that a name asks for.
struct Steps {
  std::uint64_t first, count;
};
/// Checks them against the `stored` steps of a file; 0 says that it holds a single volume, of which
/// none can be asked.
Steps check_steps(const VolumePath& path, std::string_view position, std::uint64_t stored);
/// The extent of `count` stacked steps of (X, Y, Z) voxels; checks like the other.
Extent check_extent(const std::string& file, std::string_view position,
                    const std::array<std::uint64_t, 3>& step, std::uint64_t count, VoxelType type);

/// Throws if a voxel of a volume stored as signed integers of `width` bytes (native order) is
/// negative. `box`: which voxels of the volume they are, for the error; null: unknown.
void reject_negative_voxels(const std::string& file, std::span<const std::byte> voxels,
                            std::size_t width, const Box* box = nullptr);

/// Turns floats of `width` bytes (4 or 8, native order), the voxels of `box`, into unsigned
/// integers of that width, in place. Throws InputError with value and voxel for what is no label: a
/// fraction, a negative number, NaN, and what is beyond 2^24 (2^53), above which floats of 32 (64)
/// bits leave integers out.
void labels_from_floats(const std::string& file, std::span<std::byte> voxels, std::size_t width,
                        const Box& box);

/// Whether a name ends so, without regard to case. `ending` is in small letters.
bool has_ending(std::string_view name, std::string_view ending);

/// Metres of a unit of length ("m", "cm", "mm", "um", "nm", "angstrom" and their usual spellings).
std::optional<double> metres_of(std::string_view unit);

/// Calls `take` with all voxels in slabs of whole planes, in ascending z: 64 planes each where they
/// fit into 512 MiB.
void take_slabs(const VolumeSource& source,
                const std::function<void(std::span<const std::byte>)>& take);

std::unique_ptr<VolumeSource> open_hdf5(const VolumePath& path, const OpenOptions& options);
std::unique_ptr<VolumeSource> open_nrrd(const VolumePath& path, const OpenOptions& options);
std::unique_ptr<VolumeSource> open_nifti(const VolumePath& path, const OpenOptions& options);
std::unique_ptr<VolumeSource> open_raw(const VolumePath& path, const OpenOptions& options);
std::unique_ptr<VolumeSource> open_precomputed(const VolumePath& path, const OpenOptions& options);

void write_hdf5(const VolumePath& path, const VolumeSource& source);
void write_nrrd(const VolumePath& path, const VolumeSource& source);
void write_nifti(const VolumePath& path, const VolumeSource& source);
void write_raw(const VolumePath& path, const VolumeSource& source);
void write_precomputed(const VolumePath& path, const VolumeSource& source);

/// A trailing slash, a component that ends in ".precomputed", or an existing folder in or below a
/// folder with an `info` file.
bool is_precomputed_path(const std::string& path);

}  // namespace cvr::volumes
