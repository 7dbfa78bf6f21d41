// NRRD headers ("Definition of NRRD File Format", Teem): what of them this project reads and
// writes.
//
//   NRRD000X                      magic, X = 1..5
//   field: description            one a line, each once; names and most values without regard to case
//   key:=value                    each once; ours: kind, name, source, licence
//   # comment
//   (blank line)                  ends an attached header; the data follow
//
// Read: all integer types, float, and double for labels; encodings raw, gzip, hex and ascii; both
// byte orders; one data file; line skip (before decompression), byte skip (after it; -1: the data
// are the last bytes).
//
// Axes: those of kind domain or space are x, y, z in their order; one of kind time, or a last one
// of kind list, is the time of a series; other axes must have length 1 and are dropped. The
// caller's axes overrule this.
//
// Geometry: voxel size from `space directions` (their lengths) or `spacings`, unit from `space
// units` or `units`, offset from `space origin`. Where directions run along the axes of the space
// the offset of an axis is the origin's coordinate on the axis of space that it runs along; oblique
// ones take the coordinates as they come. It is the place of the first voxel; that an axis runs
// backwards or obliquely is not kept.
//
// Fields that only describe (content, centers, thicknesses, axis mins, ...) are checked for
// existence and otherwise ignored. Everything else is an error with its line.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volumes/io/array_source.hpp"
#include "volumes/io/format.hpp"
#include "volumes/io/stored_axes.hpp"

namespace cvr::volumes {

enum class NrrdEncoding { kRaw, kGzip };

struct NrrdHeader {
  std::vector<std::uint64_t> sizes;  ///< one per axis, fastest first
  std::vector<std::string> kinds;    ///< one per axis, in small letters; empty: not said
  std::vector<double> spacings;      ///< one per axis, 1 where unknown; empty: not said
  /// One per axis: its vector, or empty for `none`.
  std::vector<std::vector<double>> directions;
  std::vector<double> space_origin;  ///< empty: not said
  std::vector<std::string> units,
      space_units;  ///< one per axis, one per axis of the space; empty: not said
  std::optional<std::size_t> space_dimension;
  StoredType type{VoxelType::kU8};
  std::string type_name;  ///< as written
  ArrayEncoding encoding = ArrayEncoding::kPlain;
  bool big_endian = false;
  std::string data_file;  ///< as written in the header; empty: attached
  std::uint64_t line_skip = 0;
  std::int64_t byte_skip = 0;  ///< -1: the voxels are the last bytes
  std::optional<VolumeKind> kind;
  Provenance provenance;
  std::uint64_t data_offset = 0;             ///< of the first byte behind the header
  std::map<std::string, std::size_t> lines;  ///< of the fields that are there

  /// "line 6" of a field.
  std::string line_of(const std::string& field) const;
};

/// Throws InputError "FILE: line N: ...".
NrrdHeader parse_nrrd_header(const std::string& file, std::string_view text);

/// What the header says of axes, voxel size, unit and offset.
struct NrrdGeometry {
  StoredAxes axes;
  std::array<double, 3> voxel_size{1, 1, 1};
  std::array<double, 3> offset{0, 0, 0};
  std::string voxel_unit;
};
/// Throws InputError "FILE: line N: ..." where fields contradict each other.
NrrdGeometry nrrd_geometry(const std::string& file, const NrrdHeader& header, VoxelType type,
                           const OpenOptions& options);

/// The header of a volume; `data_file` empty: attached, with the blank line that ends it.
std::string nrrd_header_text(const VolumeInfo& info, const Provenance& provenance,
                             NrrdEncoding encoding, const std::string& data_file);

/// A name ending in .nhdr gets a detached header beside its data in NAME.nhdr.bin (raw) or
/// NAME.nhdr.bin.gz (gzip).
void write_nrrd(const std::string& path, const VolumeSource& source, NrrdEncoding encoding);

}  // namespace cvr::volumes
